#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Zip archives: those of recordings and PyTorch's state dicts are read, USDZ packages written.

namespace fresco
{

/// Reads an archive in memory. The central directory decides; each file's own header must agree with it. No size that the archive
/// claims is believed before it is compared with the bytes that are there.
class ZipReader
{
  public:
    /// Views `bytes`. Throws Error naming source and offset: an archive that is damaged, encrypted, over 4 GiB, or packed in
    /// another way than by deflate.
    ZipReader(std::span<const std::byte> bytes, std::string_view source);

    /// The contents of a file that is stored as it is, compared with their checksum. Throws Error if there is no such file, or it
    /// is compressed or damaged.
    std::span<const std::byte> contents(const std::string& name) const;
    /// The contents of any file, of at most `most_bytes`. Throws Error as contents() does, and for larger ones.
    std::vector<std::byte> unpacked(const std::string& name, std::size_t most_bytes) const;
    bool contains(const std::string& name) const { return entries_.contains(name); }
    std::vector<std::string> names() const;  ///< Sorted.

  private:
    struct Entry
    {
        std::size_t header = 0;
        std::size_t data = 0;
        std::size_t size = 0;           ///< In the archive …
        std::size_t unpacked_size = 0;  ///< … and of the contents.
        std::uint32_t checksum = 0;
        bool is_deflated = false;
    };

    const Entry& entry(const std::string& name) const;
    [[noreturn]] void fail(std::size_t offset, const std::string& what) const;
    std::uint64_t number(std::size_t offset, std::size_t bytes) const;
    std::size_t find_end() const;
    std::size_t read_entry(std::size_t offset, std::size_t end);
    void check_header(const std::string& name, Entry& entry) const;

    std::span<const std::byte> bytes_;
    std::string source_;
    std::map<std::string, Entry> entries_;
};

/// Writes an archive by the usdz specification: data at multiples of 64 bytes, without zip64 or times (all are of 1980). Files
/// are written one after the other, in pieces of any size that are not kept.
class ZipWriter
{
  public:
    /// Throws Error if the file cannot be created.
    explicit ZipWriter(std::filesystem::path file);

    /// Begins the next file; `name` is ASCII. Throws Error if the disk is full or the archive would exceed 4 GiB, like all below.
    void begin(std::string name);
    /// Appends data to the current file.
    void write(std::string_view bytes);
    /// Ends the last file, and writes the directory of all.
    void finish();

  private:
    struct Entry
    {
        std::string name;
        std::uint64_t header = 0;
        std::uint64_t data = 0;
        std::uint64_t bytes = 0;
        std::uint32_t crc = 0;
    };

    void check_written() const;
    void put(std::string_view bytes);
    void end_entry();

    std::filesystem::path file_;
    std::ofstream stream_;
    std::uint64_t offset_ = 0;
    std::vector<Entry> entries_;
};

}  // namespace fresco
