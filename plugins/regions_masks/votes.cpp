#include "votes.h"

#include <fresco/parallel.h>

#include <algorithm>

using namespace fresco;
using raycast::Hit;

bool is_in_mask(const Raster8& mask, int x, int y)
{
    constexpr int half = 128;
    int sum = 0;
    for (int c = 0; c < mask.channels; ++c)
        sum += mask.at(x, y, c);
    return sum >= half * mask.channels;
}

std::vector<std::uint32_t> faces_in_sight(const raycast::Scene& scene, const Camera& camera, const Progress& progress)
{
    const auto width = static_cast<std::size_t>(camera.intrinsics.width);
    const auto height = static_cast<std::size_t>(camera.intrinsics.height);
    std::vector<std::uint32_t> result(width * height, Hit::none);
    constexpr std::size_t rows_per_piece = 16;
    parallel_for(height, rows_per_piece, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<Hit> hits((end - begin) * width);
                     scene.cast_rows(camera, static_cast<int>(begin), static_cast<int>(end), hits);
                     for (std::size_t i = 0; i < hits.size(); ++i)
                         if (hits[i].found() && hits[i].front)
                             result[begin * width + i] = hits[i].triangle;
                 });
    return result;
}

void Votes::add(std::size_t region, const Raster8& mask, const std::vector<std::uint32_t>& faces)
{
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
        {
            const std::uint32_t face =
                faces[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) + static_cast<std::size_t>(x)];
            if (face == Hit::none)
                continue;
            ++seen_[region][face];
            inside_[region][face] += is_in_mask(mask, x, y) ? 1 : 0;
        }
}

std::vector<std::uint32_t> Votes::winners(double least_share) const
{
    std::vector<std::uint32_t> result(inside_.front().size(), static_cast<std::uint32_t>(inside_.size()));
    for (std::size_t face = 0; face < result.size(); ++face)
    {
        double best = 0;
        for (std::uint32_t region = 0; region < inside_.size(); ++region)
        {
            const double share = seen_[region][face] == 0
                                     ? 0
                                     : static_cast<double>(inside_[region][face]) / static_cast<double>(seen_[region][face]);
            if (share > best && share >= least_share)
            {
                best = share;
                result[face] = region;
            }
        }
    }
    return result;
}

bool Votes::is_seen(std::size_t face) const
{
    return std::ranges::any_of(seen_, [&](const std::vector<std::uint32_t>& seen) { return seen[face] != 0; });
}
