#include <fresco/images/push_pull.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace fresco
{
namespace
{

struct Level
{
    RasterF picture;
    Raster8 covered;
};

/// Means over the covered ones of 2 x 2 texels.
Level halved(const RasterF& picture, const Raster8& covered)
{
    Level half{RasterF((picture.width + 1) / 2, (picture.height + 1) / 2, picture.channels),
               Raster8((picture.width + 1) / 2, (picture.height + 1) / 2)};
    for (int y = 0; y < half.covered.height; ++y)
        for (int x = 0; x < half.covered.width; ++x)
        {
            float count = 0;
            for (int v = 2 * y; v < std::min(2 * y + 2, picture.height); ++v)
                for (int u = 2 * x; u < std::min(2 * x + 2, picture.width); ++u)
                    if (covered.at(u, v) != 0)
                    {
                        ++count;
                        for (int c = 0; c < picture.channels; ++c)
                            half.picture.at(x, y, c) += picture.at(u, v, c);
                    }
            if (count == 0)
                continue;
            half.covered.at(x, y) = 1;
            for (int c = 0; c < picture.channels; ++c)
                half.picture.at(x, y, c) /= count;
        }
    return half;
}

/// The full `coarse` looked up bilinearly where `fine` is not covered.
void fill(RasterF& fine, const Raster8& covered, const RasterF& coarse)
{
    for (int y = 0; y < fine.height; ++y)
        for (int x = 0; x < fine.width; ++x)
        {
            if (covered.at(x, y) != 0)
                continue;
            const float px = std::clamp((static_cast<float>(x) + 0.5F) / 2 - 0.5F, 0.0F, static_cast<float>(coarse.width - 1));
            const float py = std::clamp((static_cast<float>(y) + 0.5F) / 2 - 0.5F, 0.0F, static_cast<float>(coarse.height - 1));
            const int x0 = static_cast<int>(px);
            const int y0 = static_cast<int>(py);
            const int x1 = std::min(x0 + 1, coarse.width - 1);
            const int y1 = std::min(y0 + 1, coarse.height - 1);
            const float fx = px - static_cast<float>(x0);
            const float fy = py - static_cast<float>(y0);
            for (int c = 0; c < fine.channels; ++c)
                fine.at(x, y, c) = (coarse.at(x0, y0, c) * (1 - fx) + coarse.at(x1, y0, c) * fx) * (1 - fy) +
                                   (coarse.at(x0, y1, c) * (1 - fx) + coarse.at(x1, y1, c) * fx) * fy;
        }
}

}  // namespace

void push_pull(RasterF& picture, const Raster8& covered)
{
    const auto is_hole = [](auto v) { return v == 0; };
    if (std::none_of(covered.values.begin(), covered.values.end(), is_hole) ||
        std::all_of(covered.values.begin(), covered.values.end(), is_hole))
        return;
    Level half = halved(picture, covered);
    push_pull(half.picture, half.covered);
    fill(picture, covered, half.picture);
}

}  // namespace fresco
