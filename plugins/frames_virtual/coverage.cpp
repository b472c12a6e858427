#include "coverage.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace fresco::virtual_views
{
namespace
{

using Numbers = std::vector<std::uint32_t>;

/// Points that are looked at together: neighbors in the texture, so that their rays stay together.
constexpr std::size_t block = 4096;

template <class Work>
void in_blocks(std::size_t count, const Progress& progress, const Work& work)
{
    parallel_for(count, block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     work(begin, end);
                 });
}

}  // namespace

Coverage::Coverage(const raycast::Scene& scene, std::span<const SurfacePoint> points, int cells_px, int gap)
    : scene_(scene), points_(points), cells_px_(cells_px), gap_(gap),
      point_in_(static_cast<std::size_t>(cells_px) * static_cast<std::size_t>(cells_px), nobody), painted_(points.size())
{
    for (std::size_t i = 0; i < points.size(); ++i)
        point_in_[points[i].cell] = static_cast<std::uint32_t>(i);
}

std::vector<std::uint32_t> Coverage::add(const Camera& camera, const Raster8& mask, const Progress& progress)
{
    std::vector<Numbers> found((points_.size() + block - 1) / block);
    in_blocks(points_.size(), progress,
              [&](std::size_t begin, std::size_t end)
              {
                  Numbers asked;
                  for (std::size_t i = begin; i < end; ++i)
                      if (painted_[i] == 0 && in_picture(camera, mask, points_[i].position))
                          asked.push_back(static_cast<std::uint32_t>(i));
                  found[begin / block] = visible_points(scene_, points_, camera.world_from_camera.translation, asked);
              });
    Numbers all;
    for (const Numbers& part : found)
        all.insert(all.end(), part.begin(), part.end());
    for (const std::uint32_t point : all)
        paint_around(point);
    return all;
}

void Coverage::paint_around(std::uint32_t point)
{
    const auto [chart, cell] = std::pair(points_[point].chart, static_cast<int>(points_[point].cell));
    const auto least = [&](int at) { return std::max(0, at - gap_); };
    const auto most = [&](int at) { return std::min(cells_px_ - 1, at + gap_); };
    for (int y = least(cell / cells_px_); y <= most(cell / cells_px_); ++y)
        for (int x = least(cell % cells_px_); x <= most(cell % cells_px_); ++x)
        {
            const std::uint32_t near = point_in_[static_cast<std::size_t>(y * cells_px_ + x)];
            if (near != nobody && points_[near].chart == chart)
                painted_[near] = 1;
        }
}

std::vector<std::uint32_t> Coverage::unpainted() const
{
    Numbers numbers;
    for (std::size_t i = 0; i < painted_.size(); ++i)
        if (painted_[i] == 0)
            numbers.push_back(static_cast<std::uint32_t>(i));
    return numbers;
}

double add_frames(Coverage& coverage, const Frames& frames, Progress& progress)
{
    std::vector<double> distances;
    std::size_t done = 0;
    for (const Frame& frame : frames.frames)
    {
        for (const std::uint32_t point : coverage.add(frame.color, load_mask(frame), progress))
            distances.push_back(
                length(vec_cast<double>(coverage.points()[point].position) - frame.color.world_from_camera.translation));
        progress.progress(static_cast<double>(++done), static_cast<double>(frames.frames.size()), "frames");
    }
    if (distances.empty())
        return 0;
    const auto middle = distances.begin() + std::ssize(distances) / 2;
    std::ranges::nth_element(distances, middle);
    return *middle;
}

std::vector<std::uint32_t> witnesses(const raycast::Scene& scene, std::span<const SurfacePoint> points,
                                     std::span<const Vec3d> places, std::span<const std::uint32_t> asked,
                                     const Progress& progress)
{
    // Far apart one after the other, so that the first few see nearly everything.
    std::size_t step = std::max<std::size_t>(1, places.size() * 5 / 8);
    while (std::gcd(step, places.size()) > 1)
        ++step;
    Numbers witness(asked.size(), nobody);
    in_blocks(asked.size(), progress,
              [&](std::size_t begin, std::size_t end)
              {
                  const auto part = asked.subspan(begin, end - begin);
                  Numbers open(part.begin(), part.end());
                  for (std::size_t i = 0; i < places.size() && !open.empty(); ++i)
                  {
                      if (i % 64 == 0)
                          progress.check_canceled();
                      const std::size_t place = i * step % places.size();
                      const Numbers seen = visible_points(scene, points, places[place], open);
                      for (const std::uint32_t point : seen)
                          witness[static_cast<std::size_t>(std::ranges::lower_bound(asked, point) - asked.begin())] =
                              static_cast<std::uint32_t>(place);
                      Numbers left;
                      std::ranges::set_difference(open, seen, std::back_inserter(left));
                      open = std::move(left);
                  }
              });
    return witness;
}

}  // namespace fresco::virtual_views
