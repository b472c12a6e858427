#include "mix.h"

#include <fresco/parallel.h>
#include <fresco/texturing/surface_average.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

void to_steps(const float* values, std::size_t count, std::uint8_t* steps)
{
    for (std::size_t i = 0; i < count; ++i)
        steps[i] = static_cast<std::uint8_t>(static_cast<int>(std::clamp(values[i], 0.0F, 1.0F) * 255.0F + 0.5F));
}

/// Sums of the distances of a row.
struct Distances
{
    double photo = 0;
    double painted = 0;
};

class RowMixer
{
  public:
    RowMixer(const RasterF& photo, const RasterF& painted, const TexelFaces& faces, MixShares shares, Mix& result)
        : photo_(photo), painted_(painted), faces_(faces), color_(static_cast<float>(shares.color)),
          strokes_(static_cast<float>(shares.strokes)), is_photo_(shares.color == 0 && shares.strokes == 0),
          is_painted_(shares.color == 1 && shares.strokes == 1), result_(result)
    {
    }

    /// `colors`: the mean on the way in, and of the photo with the mean on the way out.
    Distances mix(std::size_t row, std::vector<float>& colors) const
    {
        const std::size_t count = colors.size();
        const std::size_t first = row * count;
        const float* const photo = &photo_.values[first];
        const float* const painted = &painted_.values[first];
        float* const tones = colors.data();
        float* const mixed = &result_.rgb.values[first];
        for (std::size_t i = 0; i < count; ++i)
            tones[i] += photo[i];
        if (is_photo_ || is_painted_)
            std::copy_n(is_photo_ ? photo : painted, count, mixed);
        else
            for (std::size_t i = 0; i < count; ++i)
                mixed[i] = std::clamp(photo[i] + color_ * (tones[i] - photo[i]) + strokes_ * (painted[i] - tones[i]), 0.0F, 1.0F);
        to_steps(photo, count, &result_.photo.values[first]);
        to_steps(tones, count, &result_.colors.values[first]);
        to_steps(painted, count, &result_.painted.values[first]);
        Distances sum;
        for (std::size_t i = 0; i < count; i += 3)
        {
            const float inside = faces_.inside[(first + i) / 3];
            const auto apart = [&](const float* other)
            {
                return inside * (std::abs(mixed[i] - other[i]) + std::abs(mixed[i + 1] - other[i + 1]) +
                                 std::abs(mixed[i + 2] - other[i + 2]));
            };
            sum.photo += double{apart(photo)};
            sum.painted += double{apart(painted)};
        }
        return sum;
    }

  private:
    const RasterF& photo_;
    const RasterF& painted_;
    const TexelFaces& faces_;
    float color_;
    float strokes_;
    bool is_photo_;
    bool is_painted_;
    Mix& result_;
};

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
    const SurfaceAverage average = difference.averaged(split_m, "split_cm", progress);
    const auto size = static_cast<std::size_t>(faces.size);
    const auto steps = [&] { return Raster8(faces.size, faces.size, 3); };
    Mix result{RasterF(faces.size, faces.size, 3), steps(), steps(), steps()};
    const RowMixer mixer(photo, painted, faces, shares, result);
    std::vector<Distances> sums(size);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(size, rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     SurfaceAverage::Lookup lookup(average);
                     std::vector<float> colors(3 * size);
                     for (std::size_t row = begin; row < end; ++row)
                     {
                         difference.mean_of_row(row, lookup, colors);
                         sums[row] = mixer.mix(row, colors);
                     }
                 });
    const auto texels = std::count(faces.inside.begin(), faces.inside.end(), std::uint8_t{1});
    const double scale = texels == 0 ? 0 : 255 / (3.0 * static_cast<double>(texels));
    for (const Distances& sum : sums)
    {
        result.from_photo += scale * sum.photo;
        result.from_painted += scale * sum.painted;
    }
    return result;
}
