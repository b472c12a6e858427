#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

/// Where the data of each file of a package begin, in bytes.
inline constexpr std::uint64_t zip_alignment = 64;

/// Writes a zip archive as the usdz specification wants it: files stored as they are, their data at multiples of 64 bytes,
/// neither zip64 nor times (all are of 1980). Files come one after the other, in pieces of any size, none of which is kept.
class ZipWriter
{
  public:
    /// Throws Error if the file cannot be created.
    explicit ZipWriter(std::filesystem::path file);

    /// Begins the next file; `name` is ASCII. Throws Error if the disk is full or the archive would exceed 4 GiB, as all below.
    void begin(std::string name);
    /// More data of it.
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
