#include "key_weights.h"

#include "nearest_keys.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>

namespace fresco::synthesize
{
namespace
{

constexpr std::size_t keys_per_piece = 192;
constexpr double window_share = 0.01;  // Of the picture's area.
constexpr double fair_use = 3;         // Times the mean.
constexpr double crowd_step = 0.5;     // Of a factor in a round, as a power.

}  // namespace

std::vector<float> completeness_weights(const PictureLevel& picture, std::span<const float> queries, double alpha,
                                        const Progress& progress)
{
    const std::size_t size = picture.feature_count();
    const std::vector<float> alike(queries.size() / size, 1.0F);
    const NearestKeys nearest_queries(queries, {size, 0}, alike, 0, patch_kernel());
    const auto least = static_cast<float>(alpha * static_cast<double>(picture.values_per_patch()));
    std::vector<float> weights(picture.key_count());
    parallel_for(weights.size(), keys_per_piece, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<Nearest> nearest(end - begin);
                     nearest_queries.find(&picture.key_features()[begin * size], end - begin, nearest.data());
                     for (std::size_t i = begin; i < end; ++i)
                         weights[i] = 1 / (least + std::max(nearest[i - begin].score, 0.0F));
                 });
    return weights;
}

void update_crowding(const PictureLevel& picture, std::span<const Match> matches, std::vector<float>& crowding)
{
    const int width = picture.lab().width;
    const int height = picture.lab().height;
    Raster<std::uint32_t> sums(width + 1, height + 1);  // Of the matches above and to the left.
    for (const Match& match : matches)
        ++sums.at(static_cast<int>(match.at.x) + 1, static_cast<int>(match.at.y) + 1);
    for (int y = 1; y <= height; ++y)
        for (int x = 1; x <= width; ++x)
            sums.at(x, y) += sums.at(x - 1, y) + sums.at(x, y - 1) - sums.at(x - 1, y - 1);
    const double area = static_cast<double>(width) * height;
    const int half = std::max(1, static_cast<int>(std::lround(std::sqrt(window_share * area) / 2)));
    for (std::size_t key = 0; key < crowding.size(); ++key)
    {
        const Vec2f at = picture.key(key);
        const int x0 = std::max(0, static_cast<int>(at.x) - half);
        const int x1 = std::min(width, static_cast<int>(at.x) + half);
        const int y0 = std::max(0, static_cast<int>(at.y) - half);
        const int y1 = std::min(height, static_cast<int>(at.y) + half);
        const double count = sums.at(x1, y1) + sums.at(x0, y0) - sums.at(x0, y1) - sums.at(x1, y0);
        const double use = count / static_cast<double>(matches.size()) * area / (static_cast<double>(x1 - x0) * (y1 - y0));
        crowding[key] = std::max(1.0F, crowding[key] * static_cast<float>(std::pow(use / fair_use, crowd_step)));
    }
}

}  // namespace fresco::synthesize
