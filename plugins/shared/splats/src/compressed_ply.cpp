#include "formats.h"

#include <algorithm>
#include <numbers>

namespace fresco::splats
{
namespace
{

constexpr std::size_t chunk_rows = 256;

/// The `bits` lowest ones above `shift`, as a fraction of the largest such number.
double fraction(std::uint32_t packed, unsigned shift, unsigned bits)
{
    const std::uint32_t most = (1U << bits) - 1;
    return static_cast<double>(packed >> shift & most) / most;
}

Vec3d fractions_11_10_11(std::uint32_t packed)
{
    return {fraction(packed, 21, 11), fraction(packed, 11, 10), fraction(packed, 0, 11)};
}

/// The three smaller components of a unit quaternion, behind the number of the largest.
std::array<double, 4> unpacked_rotation(std::uint32_t packed)
{
    const auto component = [&](unsigned shift) { return (fraction(packed, shift, 10) - 0.5) * std::numbers::sqrt2; };
    return completed({component(20), component(10), component(0)}, packed >> 30U);
}

}  // namespace

SplatFile parse_compressed_ply(Bytes bytes, const PlyRows& chunk, const PlyRows& vertex, const std::string& source)
{
    if (chunk.begin > vertex.begin || chunk.count != (vertex.count + chunk_rows - 1) / chunk_rows)
        throw Error(fmt::format("{}: has {} vertices in {} chunks; expected {} vertices in each chunk but the last", source,
                                vertex.count, chunk.count, chunk_rows));
    const auto three = [&](const std::string& what, const char* axes)
    {
        std::array<std::size_t, 3> offsets{};
        for (std::size_t k = 0; k < 3; ++k)
            offsets[k] = chunk.offset_of(what + axes[k], PlyType::float32, source);
        return offsets;
    };
    const auto low = three("min_", "xyz");
    const auto high = three("max_", "xyz");
    const auto scale_low = three("min_scale_", "xyz");
    const auto scale_high = three("max_scale_", "xyz");
    const bool has_colors = std::ranges::find(chunk.properties, "min_r", &PlyProperty::name) != chunk.properties.end();
    const auto color_low = has_colors ? three("min_", "rgb") : low;
    const auto color_high = has_colors ? three("max_", "rgb") : high;
    const auto packed_at = [&](const char* name) { return vertex.offset_of(name, PlyType::uint32, source); };
    const std::size_t position = packed_at("packed_position");
    const std::size_t rotation = packed_at("packed_rotation");
    const std::size_t scale = packed_at("packed_scale");
    const std::size_t color = packed_at("packed_color");

    SplatFile file;
    file.format = SplatFormat::compressed_ply;
    resize(file.splats, vertex.count);
    for (std::size_t i = 0; i < vertex.count; ++i)
    {
        const Bytes range = bytes.subspan(chunk.begin + i / chunk_rows * chunk.row_bytes, chunk.row_bytes);
        const Bytes row = bytes.subspan(vertex.begin + i * vertex.row_bytes, vertex.row_bytes);
        const auto between = [&](const std::array<std::size_t, 3>& from, const std::array<std::size_t, 3>& to, Vec3d share)
        {
            const auto mix = [&](std::size_t k, double t)
            { return value_at<float>(range, from[k]) * (1 - t) + value_at<float>(range, to[k]) * t; };
            return Vec3d{mix(0, share.x), mix(1, share.y), mix(2, share.z)};
        };
        const auto packed = [&](std::size_t at) { return value_at<std::uint32_t>(row, at); };
        const Vec3d shade{fraction(packed(color), 24, 8), fraction(packed(color), 16, 8), fraction(packed(color), 8, 8)};
        set(file.splats, i, vec_cast<float>(between(low, high, fractions_11_10_11(packed(position)))),
            unpacked_rotation(packed(rotation)), between(scale_low, scale_high, fractions_11_10_11(packed(scale))),
            fraction(packed(color), 0, 8), vec_cast<float>(has_colors ? between(color_low, color_high, shade) : shade), source);
    }
    return file;
}

}  // namespace fresco::splats
