#pragma once

#include <fresco/splats/splats.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

/// \file Splats written with other colors. What export.splats does not change stays byte for byte as the user's file has it.

namespace fresco::splats
{

/// Gaussians to be written: each is one of a file with another color, or a part of one.
struct PaintedSplats
{
    struct Part
    {
        std::uint32_t source = 0;  ///< Index of the Gaussian in the file.
        bool is_split = false;     ///< Center, scale and opacity are new; otherwise they stay as they are in the file.
        bool keeps_color = false;  ///< The color and the harmonics stay, too.
        Vec3f center;
        Vec3f scale;
        float opacity = 0;
        Vec3f color;  ///< sRGB, 0 to 1.

        friend bool operator==(const Part&, const Part&) = default;
    };
    std::vector<Part> parts;
};

/// Whether files of this format are written: PLY, SPLAT, SPZ.
bool is_written(SplatFormat format);

/// The bytes of a file in this format, which must be one that is written. In the format of `file` they are its own with new
/// colors: rotations, normals, other properties, bytes behind the last Gaussian, records of vendors and SPZ's version stay.
/// Otherwise a plain one is made from the numbers of `file`. `keeps_harmonics`: above degree 0, in the file's own format;
/// else they are left out, which for Gaussians that keep their color is a change, too. Throws Error if the file changed since it
/// was read, or does not fit the format.
std::vector<std::byte> painted_bytes(const std::filesystem::path& path, const SplatFile& file, const PaintedSplats& painted,
                                     SplatFormat format, bool keeps_harmonics);

/// A plain file of these splats.
std::vector<std::byte> bytes_of(const Splats& splats, SplatFormat format);

}  // namespace fresco::splats
