#include <fresco/geometry/surface_search.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace fresco::geometry
{

namespace
{

constexpr std::uint32_t leaf_faces = 4;
constexpr std::size_t deepest = 64;  // a median split halves the faces: 32 levels for as many as there can be
// A box's distance and a triangle's are rounded differently.
constexpr double rounding = 1 + 1e-12;

float along(Vec3f p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

double squared_distance_to_box(Vec3d p, Vec3f low, Vec3f high)
{
    const auto outside = [](double at, float from, float to) { return std::max({double{from} - at, at - double{to}, 0.0}); };
    const Vec3d away{outside(p.x, low.x, high.x), outside(p.y, low.y, high.y), outside(p.z, low.z, high.z)};
    return dot(away, away);
}

}  // namespace

std::array<double, 3> nearest_weights(const std::array<Vec3d, 3>& corners, Vec3d p)
{
    const auto& [a, b, c] = corners;
    const Vec3d ab = b - a;
    const Vec3d ac = c - a;
    const double d1 = dot(ab, p - a);
    const double d2 = dot(ac, p - a);
    if (d1 <= 0 && d2 <= 0)
        return {1, 0, 0};
    const double d3 = dot(ab, p - b);
    const double d4 = dot(ac, p - b);
    if (d3 >= 0 && d4 <= d3)
        return {0, 1, 0};
    const double beside_ab = d1 * d4 - d3 * d2;
    if (beside_ab <= 0 && d1 >= 0 && d3 <= 0)
        return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
    const double d5 = dot(ab, p - c);
    const double d6 = dot(ac, p - c);
    if (d6 >= 0 && d5 <= d6)
        return {0, 0, 1};
    const double beside_ac = d5 * d2 - d1 * d6;
    if (beside_ac <= 0 && d2 >= 0 && d6 <= 0)
        return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
    const double beside_bc = d3 * d6 - d5 * d4;
    if (beside_bc <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    {
        const double share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - share, share};
    }
    const double sum = beside_ab + beside_ac + beside_bc;
    return {1 - beside_ac / sum - beside_ab / sum, beside_ac / sum, beside_ab / sum};
}

SurfaceSearch::SurfaceSearch(const Mesh& mesh) : mesh_(mesh), order_(mesh.triangles.size())
{
    std::iota(order_.begin(), order_.end(), 0U);
    std::vector<Vec3f> middles;
    middles.reserve(mesh.triangles.size());
    for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
    {
        const auto c = corners(face);
        middles.push_back(vec_cast<float>((c[0] + c[1] + c[2]) * (1.0 / 3)));
    }
    nodes_.reserve(order_.size());
    build(0, static_cast<std::uint32_t>(order_.size()), middles);
}

std::array<Vec3d, 3> SurfaceSearch::corners(std::uint32_t face) const
{
    const auto& t = mesh_.triangles[face];
    return {vec_cast<double>(mesh_.positions[t[0]]), vec_cast<double>(mesh_.positions[t[1]]),
            vec_cast<double>(mesh_.positions[t[2]])};
}

std::uint32_t SurfaceSearch::build(std::uint32_t begin, std::uint32_t end, const std::vector<Vec3f>& middles)
{
    numerics::Bounds<float> box;
    for (std::uint32_t i = begin; i < end; ++i)
        for (const std::uint32_t vertex : mesh_.triangles[order_[i]])
            box.add(mesh_.positions[vertex]);
    const Node node{box.low, box.high, begin, end - begin};
    const auto number = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back(node);
    if (node.count <= leaf_faces)
        return number;
    const Vec3f extent = node.high - node.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::uint32_t middle = begin + node.count / 2;
    const auto at = [this](std::uint32_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [&](std::uint32_t a, std::uint32_t b)
                     { return std::pair(along(middles[a], axis), a) < std::pair(along(middles[b], axis), b); });
    build(begin, middle, middles);
    const std::uint32_t second = build(middle, end, middles);
    nodes_[number].first = second;
    nodes_[number].count = 0;
    return number;
}

void SurfaceSearch::try_face(std::uint32_t face, Vec3d p, const Vec3d* normal, SurfacePoint& best) const
{
    const auto c = corners(face);
    if (normal != nullptr && !(dot(cross(c[1] - c[0], c[2] - c[0]), *normal) > 0))
        return;
    const auto weights = nearest_weights(c, p);
    const Vec3d away = c[0] * weights[0] + c[1] * weights[1] + c[2] * weights[2] - p;
    const double squared = dot(away, away);
    if (squared < best.squared_distance || (squared == best.squared_distance && face < best.face))
        best = {face, weights, squared};
}

SurfacePoint SurfaceSearch::nearest(Vec3d p, double reach) const
{
    return search(p, nullptr, reach, SurfacePoint::none);
}

SurfacePoint SurfaceSearch::nearest_facing(Vec3d p, Vec3d normal, double reach, std::uint32_t hint) const
{
    return search(p, &normal, reach, hint);
}

SurfacePoint SurfaceSearch::search(Vec3d p, const Vec3d* normal, double reach, std::uint32_t hint) const
{
    SurfacePoint best;
    // A point at exactly this distance still counts: no face has a greater number than none.
    best.squared_distance = reach * reach;
    if (hint < mesh_.triangles.size())
        try_face(hint, p, normal, best);
    struct Open
    {
        std::uint32_t node;
        double squared;
    };
    std::array<Open, deepest> open;
    std::size_t count = 0;
    const auto distance_of = [&](std::uint32_t node) { return squared_distance_to_box(p, nodes_[node].low, nodes_[node].high); };
    open[count++] = {0, distance_of(0)};
    while (count > 0)
    {
        const Open next = open[--count];
        if (next.squared > best.squared_distance * rounding)
            continue;
        const Node& node = nodes_[next.node];
        for (std::uint32_t i = 0; i < node.count; ++i)
            try_face(order_[node.first + i], p, normal, best);
        if (node.count > 0)
            continue;
        Open nearer{next.node + 1, distance_of(next.node + 1)};
        Open farther{node.first, distance_of(node.first)};
        if (farther.squared < nearer.squared)
            std::swap(nearer, farther);
        open[count++] = farther;
        open[count++] = nearer;
    }
    return best;
}

}  // namespace fresco::geometry
