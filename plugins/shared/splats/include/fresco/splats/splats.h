#pragma once

#include <fresco/math.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Files of Gaussian splats. scan.splats makes a surface from them; export.splats gives them the painting's colors.

namespace fresco::splats
{

/// Gaussians in the axes and units of their file.
struct Splats
{
    std::vector<Vec3f> centers;
    std::vector<std::array<float, 4>> rotations;  ///< Unit quaternions: w, x, y, z.
    std::vector<Vec3f> scales;                    ///< Standard deviations along the three rotated axes; above 0.
    std::vector<float> opacities;                 ///< 0 to 1.
    std::vector<Vec3f> colors;                    ///< sRGB, without the harmonics above degree 0; may leave [0,1].

    std::size_t size() const { return centers.size(); }
};

void resize(Splats& splats, std::size_t count);
/// The axes of a Gaussian, of unit length.
std::array<Vec3d, 3> axes_of(const Splats& splats, std::size_t i);

enum class SplatFormat
{
    ply,             ///< As INRIA's trainer writes them.
    compressed_ply,  ///< PlayCanvas'.
    splat,           ///< antimatter15's: 32 bytes per Gaussian.
    spz,             ///< Niantic's, versions 2 to 4.
    sog,             ///< PlayCanvas', version 2.
    glb              ///< glTF with KHR_gaussian_splatting.
};

std::string_view name_of(SplatFormat format);
/// Whether files of this format are in meters, with +y up.
bool is_metric(SplatFormat format);

struct SplatFile
{
    SplatFormat format{};
    Splats splats;
    std::vector<std::filesystem::path> files;  ///< Files that read_splats opened.
};

/// Reads a file, which its contents identify, or the folder of a SOG. Bytes behind the last Gaussian are ignored. Throws Error
/// naming the file and the place in it: formats that are not read, a file that is cut short, sizes that its bytes do not justify,
/// numbers that are not finite. MissingInput if it cannot be opened.
SplatFile read_splats(const std::filesystem::path& file);
/// Reads the bytes of a file, which errors call `source`.
SplatFile parse_splats(std::span<const std::byte> bytes, const std::string& source);

}  // namespace fresco::splats
