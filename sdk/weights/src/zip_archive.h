#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace fresco::weights::detail
{

/// The entries of a zip archive whose entries are stored, not compressed, as PyTorch writes them. The central directory decides;
/// each entry's own header must agree with it, and no two may overlap.
class ZipArchive
{
  public:
    /// Throws Error naming source and offset.
    ZipArchive(std::span<const std::byte> bytes, std::string_view source);

    /// The contents, compared with their checksum. Throws Error if there is no such entry or it is damaged.
    std::span<const std::byte> contents(const std::string& name) const;
    bool contains(const std::string& name) const { return entries_.contains(name); }
    /// The name of the one entry that ends so. Throws Error unless there is exactly one.
    std::string only_name_with_end(std::string_view end) const;

  private:
    struct Entry
    {
        std::size_t header = 0;
        std::size_t data = 0;
        std::size_t size = 0;
        std::uint32_t checksum = 0;
    };

    [[noreturn]] void fail(std::size_t offset, const std::string& what) const;
    std::uint64_t number(std::size_t offset, std::size_t bytes) const;
    std::size_t find_end() const;
    std::size_t read_entry(std::size_t offset, std::size_t end);
    void check_header(const std::string& name, Entry& entry) const;
    void check_overlaps(std::size_t directory) const;

    std::span<const std::byte> bytes_;
    std::string source_;
    std::map<std::string, Entry> entries_;
};

}  // namespace fresco::weights::detail
