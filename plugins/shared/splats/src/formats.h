#pragma once

#include <fresco/error.h>
#include <fresco/ply_header.h>
#include <fresco/splats/splats.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>

/// \file What the readers of the formats share.

namespace fresco::splats
{

using Bytes = std::span<const std::byte>;

inline constexpr double harmonic_0 = 0.28209479177387814;  ///< The spherical harmonic of degree 0: 1 / (2 sqrt(pi)).

/// A little-endian value at an offset that lies within the bytes.
template <class T>
T value_at(Bytes bytes, std::size_t offset)
{
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

inline double sigmoid(double x)
{
    return 1 / (1 + std::exp(-x));
}

/// Coefficients per channel above degree 0.
constexpr std::size_t coefficients_of(int degree)
{
    return static_cast<std::size_t>((degree + 1) * (degree + 1) - 1);
}

/// The quaternion of length 1 of which the numbers but the `missing` one, which is positive, are these.
inline std::array<double, 4> completed(const std::array<double, 3>& others, std::size_t missing)
{
    std::array<double, 4> rotation{};
    double rest = 1;
    for (std::size_t k = 0; k < 3; ++k)
    {
        rotation[k < missing ? k : k + 1] = others[k];
        rest -= others[k] * others[k];
    }
    rotation[missing] = std::sqrt(std::max(rest, 0.0));
    return rotation;
}

/// Sets Gaussian `i`, with a quaternion of any length and the logarithms of its scales. Throws Error naming `source` and the
/// Gaussian if a number is not finite. A quaternion of length 0 has no axes: the Gaussian gets opacity 0.
void set(Splats& splats, std::size_t i, Vec3f center, std::array<double, 4> rotation, Vec3<double> log_scale, double opacity,
         Vec3f color, const std::string& source);

/// The rows of an element of a PLY file, which has no lists.
struct PlyRows : PlyElement
{
    std::size_t begin = 0;  ///< Offset of the first row.
    std::size_t row_bytes = 0;

    /// Offset in a row of a property of this type; throws Error if it is missing.
    std::size_t offset_of(std::string_view property, PlyType type, const std::string& source) const;
};

/// The properties of a Gaussian: center, color, opacity, scales, quaternion.
inline constexpr std::array<std::string_view, 14> gaussian_names{
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"};
/// In the order of gaussian_names. Throws Error if one is missing.
std::array<std::size_t, 14> gaussian_offsets(const PlyRows& vertex, const std::string& source);

/// Reads the header, up to the first element behind the vertices that has lists. Throws Error if the rows are not all there.
std::vector<PlyRows> ply_rows(Bytes bytes, const std::string& source);
/// Null if there is no such element.
const PlyRows* find_rows(const std::vector<PlyRows>& elements, std::string_view name);

SplatFile parse_ply(Bytes bytes, const std::string& source);
SplatFile parse_compressed_ply(Bytes bytes, const PlyRows& chunk, const PlyRows& vertex, const std::string& source);

/// Rows of 32 bytes without a header: their numbers must be plausible.
inline constexpr std::size_t splat_row_bytes = 32;
bool is_splat(Bytes bytes);
SplatFile parse_splat(Bytes bytes, const std::string& source);

/// An SPZ file, unpacked.
struct SpzContents
{
    enum Stream : std::uint8_t
    {
        positions,
        opacities,
        colors,
        scales,
        rotations,
        harmonics
    };

    int version = 0;
    std::size_t count = 0;
    int degree = 0;
    int fraction_bits = 0;
    std::uint8_t flags = 0;
    std::array<std::vector<std::byte>, 6> streams;
    std::vector<std::byte> extensions;  ///< Records of vendors, as they are.

    /// Bytes per Gaussian of each stream.
    std::array<std::size_t, 6> row_bytes() const;
    std::size_t bytes_per_gaussian() const;
    void put(std::size_t i, Vec3f center, Vec3f scale, double opacity);
    void put_color(std::size_t i, Vec3f color);
};

bool is_spz(Bytes bytes);
SpzContents unpacked_spz(Bytes bytes, const std::string& source);
std::vector<std::byte> packed_spz(const SpzContents& spz);
SpzContents spz_of(const Splats& splats);
SplatFile parse_spz(Bytes bytes, const std::string& source);

SplatFile parse_glb(Bytes bytes, const std::string& source);

/// The bytes of a file of a SOG, by its name in meta.json.
using SogFile = std::function<std::vector<std::byte>(const std::string& name)>;
/// `total_bytes`: of all files, which bound the number of Gaussians.
SplatFile parse_sog(std::string_view meta, const SogFile& file, std::size_t total_bytes, const std::string& source);

}  // namespace fresco::splats
