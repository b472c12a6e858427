#include "mix.h"

#include <fresco/parallel.h>
#include <fresco/texturing/surface_average.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

/// Sums of the distances of a row.
struct Distances
{
    double photo = 0;
    double painted = 0;
};

/// `colors`: the mean of a row on the way in, and of the photo with the mean on the way out.
Distances mix_row(const RasterF& photo, const RasterF& painted, const TexelFaces& faces, MixShares shares, std::size_t row,
                  std::vector<float>& colors, Mix& result)
{
    const auto color = static_cast<float>(shares.color);
    const auto strokes = static_cast<float>(shares.strokes);
    const bool is_photo = shares.color == 0 && shares.strokes == 0;
    const bool is_painted = shares.color == 1 && shares.strokes == 1;
    const std::size_t count = colors.size();
    const std::size_t first = row * count;
    const float* const from = &photo.values[first];
    const float* const to = &painted.values[first];
    float* const tones = colors.data();
    float* const mixed = &result.rgb.values[first];
    for (std::size_t i = 0; i < count; ++i)
        tones[i] += from[i];
    if (is_photo || is_painted)
        std::copy_n(is_photo ? from : to, count, mixed);
    else
        for (std::size_t i = 0; i < count; ++i)
            mixed[i] = std::clamp(from[i] + color * (tones[i] - from[i]) + strokes * (to[i] - tones[i]), 0.0F, 1.0F);
    for (std::size_t i = 0; i < count; ++i)
        result.colors.values[first + i] = static_cast<std::uint8_t>(std::clamp(tones[i], 0.0F, 1.0F) * 255.0F + 0.5F);
    Distances sum;
    for (std::size_t i = 0; i < count; i += 3)
    {
        const float inside = faces.inside[(first + i) / 3];
        const auto apart = [&](const float* other)
        {
            return inside * (std::abs(mixed[i] - other[i]) + std::abs(mixed[i + 1] - other[i + 1]) +
                             std::abs(mixed[i + 2] - other[i + 2]));
        };
        sum.photo += double{apart(from)};
        sum.painted += double{apart(to)};
    }
    return sum;
}

}  // namespace

Mix mix(const RasterF& photo, const RasterF& painted, const Mesh& mesh, const TexelFaces& faces, double split_m, MixShares shares,
        const Progress& progress)
{
    const TexelMeans difference(mesh, faces,
                                [&](std::size_t texel)
                                {
                                    const float* const from = &photo.values[3 * texel];
                                    const float* const to = &painted.values[3 * texel];
                                    return Vec3f{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
                                });
    const auto size = static_cast<std::size_t>(faces.size);
    Mix result{RasterF(faces.size, faces.size, 3), to_bytes(photo, progress), Raster8(faces.size, faces.size, 3),
               to_bytes(painted, progress)};
    std::vector<Distances> sums(size);
    difference.each_row(split_m, "split_cm", progress,
                        [&](std::size_t row, std::vector<float>& colors)
                        { sums[row] = mix_row(photo, painted, faces, shares, row, colors, result); });
    const auto texels = std::count(faces.inside.begin(), faces.inside.end(), std::uint8_t{1});
    const double scale = texels == 0 ? 0 : 255 / (3.0 * static_cast<double>(texels));
    for (const Distances& sum : sums)
    {
        result.from_photo += scale * sum.photo;
        result.from_painted += scale * sum.painted;
    }
    return result;
}
