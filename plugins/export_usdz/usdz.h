#pragma once

#include <fresco/texturing/exports.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// \file Writes a textured mesh as a USDZ package: a USD layer as text (write_usda) in an aligned zip archive (ZipWriter). The
/// stage writes both, then reads the package back (read_usdz, check_usda).

struct UsdaOptions
{
    std::string picture;    ///< Name of the picture in the package.
    bool lit;               ///< Lit, rough, not metallic, with smooth normals; otherwise black, emitting the picture.
    std::string normals{};  ///< Name of the normal map; empty, like the next: none.
    std::string roughness{};
};

/// Called with successive pieces of a text.
using WriteText = std::function<void(std::string_view)>;

/// A USD layer of one textured mesh as text (UTF-8), in meters, y up. The mesh is written unchanged, bit by bit; a
/// transform moves the middle of its box above the origin and its lowest point to the origin's level, to the millimeter, so that
/// phones put it on the floor. Pieces are about a megabyte.
void write_usda(const fresco::texturing::WeldedMesh& mesh, const UsdaOptions& options, const WriteText& write);

/// Writes a zip archive by the usdz specification: files are stored uncompressed, with their data at multiples of 64 bytes,
/// without zip64 or times (all are of 1980). Files are written one after the other, in pieces of any size that are not kept.
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

/// A file of a package; `data` points into the package.
struct UsdzEntry
{
    std::string name;
    std::string_view data;
};

/// Reads a package and checks it against the usdz specification, byte by byte: files stored uncompressed, data at multiples of 64
/// bytes, headers and directory in agreement, correct checksums, no bytes between or behind. Throws Error naming `source`, the
/// file in the package, and what was expected.
std::vector<UsdzEntry> read_usdz(std::string_view package, std::string_view source);

/// Compares the numbers of a layer with the mesh: triangles, positions and texcoords, bit by bit. Throws
/// Error naming the first difference.
void check_usda(std::string_view layer, const fresco::texturing::WeldedMesh& mesh);
