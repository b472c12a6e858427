#include <fresco/geometry/closest_triangle.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace fresco::geometry
{
namespace
{

constexpr std::size_t leaf_size = 4;

Vec3d closest_on_segment(Vec3d a, Vec3d b, Vec3d point)
{
    const Vec3d along = b - a;
    const double square = dot(along, along);
    const double t = square > 0 ? std::clamp(dot(point - a, along) / square, 0.0, 1.0) : 0;
    return a + along * t;
}

bool projects_inside(const Corners3& t, Vec3d normal, Vec3d point)
{
    for (std::size_t k = 0; k < 3; ++k)
        if (dot(cross(t[(k + 1) % 3] - t[k], point - t[k]), normal) < 0)
            return false;
    return true;
}

double axis(Vec3d v, int which)
{
    return which == 0 ? v.x : which == 1 ? v.y : v.z;
}

double box_distance(Vec3d low, Vec3d high, Vec3d p)
{
    const Vec3d out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                    std::max({low.z - p.z, 0.0, p.z - high.z})};
    return length(out);
}

}  // namespace

Vec3d closest_point(const Corners3& triangle, Vec3d point)
{
    const Vec3d normal = normalized(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
    if (normal != Vec3d{} && projects_inside(triangle, normal, point))
        return point - normal * dot(point - triangle[0], normal);
    Vec3d best = triangle[0];
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vec3d candidate = closest_on_segment(triangle[k], triangle[(k + 1) % 3], point);
        if (const double distance = length(candidate - point); distance < least)
        {
            least = distance;
            best = candidate;
        }
    }
    return best;
}

ClosestTriangle::ClosestTriangle(std::vector<Corners3> triangles) : triangles_(std::move(triangles)), order_(triangles_.size())
{
    std::iota(order_.begin(), order_.end(), 0U);
    nodes_.emplace_back();
    build(0, 0, order_.size());
}

void ClosestTriangle::build(std::size_t node, std::size_t begin, std::size_t end)
{
    constexpr double far = std::numeric_limits<double>::infinity();
    Vec3d low{far, far, far};
    Vec3d high{-far, -far, -far};
    for (std::size_t i = begin; i < end; ++i)
        for (const Vec3d& p : triangles_[order_[i]])
        {
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
    nodes_[node].low = low;
    nodes_[node].high = high;
    if (end - begin <= leaf_size)
    {
        nodes_[node].first = static_cast<std::uint32_t>(begin);
        nodes_[node].count = static_cast<std::uint32_t>(end - begin);
        return;
    }
    const Vec3d size = high - low;
    const int widest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto center = [&](std::uint32_t t)
    { return axis(triangles_[t][0], widest) + axis(triangles_[t][1], widest) + axis(triangles_[t][2], widest); };
    const std::size_t middle = (begin + end) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](auto a, auto b) { return center(a) < center(b); });
    const std::size_t children = nodes_.size();
    nodes_[node].first = static_cast<std::uint32_t>(children);
    nodes_.resize(children + 2);
    build(children, begin, middle);
    build(children + 1, middle, end);
}

void ClosestTriangle::search(std::size_t node, Vec3d point, Closest& best) const
{
    const Node& here = nodes_[node];
    if (here.count > 0)
    {
        for (std::size_t i = here.first; i < here.first + here.count; ++i)
        {
            const Vec3d candidate = closest_point(triangles_[order_[i]], point);
            if (const double distance = length(candidate - point); distance < best.distance)
                best = {order_[i], candidate, distance};
        }
        return;
    }
    std::array<std::size_t, 2> child{here.first, here.first + std::size_t{1}};
    std::array<double, 2> away{box_distance(nodes_[child[0]].low, nodes_[child[0]].high, point),
                               box_distance(nodes_[child[1]].low, nodes_[child[1]].high, point)};
    if (away[1] < away[0])
    {
        std::swap(child[0], child[1]);
        std::swap(away[0], away[1]);
    }
    for (std::size_t i = 0; i < 2; ++i)
        if (away[i] < best.distance)
            search(child[i], point, best);
}

Closest ClosestTriangle::find(Vec3d point, double within) const
{
    Closest best{0, {}, within};
    search(0, point, best);
    if (!(best.distance < within))
        best.distance = std::numeric_limits<double>::infinity();
    return best;
}

}  // namespace fresco::geometry
