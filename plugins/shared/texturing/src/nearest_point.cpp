#include "nearest_point.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace fresco::texturing
{

namespace
{
float along(Vec3f p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}
}  // namespace

struct NearestPoint::Best
{
    float squared = std::numeric_limits<float>::infinity();
    std::uint32_t point = std::numeric_limits<std::uint32_t>::max();
};

NearestPoint::NearestPoint(std::vector<Vec3f> points) : points_(std::move(points)), order_(points_.size())
{
    std::iota(order_.begin(), order_.end(), 0U);
    split(0, order_.size(), 0);
}

void NearestPoint::split(std::size_t begin, std::size_t end, int axis)
{
    if (end - begin < 2)
        return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [&](std::uint32_t a, std::uint32_t b)
                     { return std::pair(along(points_[a], axis), a) < std::pair(along(points_[b], axis), b); });
    split(begin, middle, (axis + 1) % 3);
    split(middle + 1, end, (axis + 1) % 3);
}

void NearestPoint::search(Vec3f query, std::size_t begin, std::size_t end, int axis, Best& best) const
{
    if (begin >= end)
        return;
    const std::size_t middle = begin + (end - begin) / 2;
    const std::uint32_t point = order_[middle];
    const Vec3f away = points_[point] - query;
    const float squared = dot(away, away);
    if (std::tie(squared, point) < std::tie(best.squared, best.point))
        best = {squared, point};
    const float to_plane = along(query, axis) - along(points_[point], axis);
    const int next = (axis + 1) % 3;
    if (to_plane < 0)
        search(query, begin, middle, next, best);
    else
        search(query, middle + 1, end, next, best);
    if (to_plane * to_plane > best.squared)
        return;
    if (to_plane < 0)
        search(query, middle + 1, end, next, best);
    else
        search(query, begin, middle, next, best);
}

std::size_t NearestPoint::find(Vec3f query) const
{
    Best best;
    search(query, 0, order_.size(), 0, best);
    return best.point;
}

}  // namespace fresco::texturing
