#include "caster.h"

#include <algorithm>
#include <array>

namespace room
{

namespace
{

constexpr std::size_t leaf_size = 2;

float component(Vec3f v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

Vec3f lower(Vec3f a, Vec3f b)
{
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}

Vec3f upper(Vec3f a, Vec3f b)
{
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// Where a ray enters a box, or a large number if it misses it or does so beyond `limit`.
[[gnu::always_inline]] inline float entry(const Vec3f& low, const Vec3f& high, const Vec3f& origin, const Vec3f& inverse,
                                          float limit)
{
    const float x0 = (low.x - origin.x) * inverse.x, x1 = (high.x - origin.x) * inverse.x;
    const float y0 = (low.y - origin.y) * inverse.y, y1 = (high.y - origin.y) * inverse.y;
    const float z0 = (low.z - origin.z) * inverse.z, z1 = (high.z - origin.z) * inverse.z;
    const float enter = std::max(std::max(std::min(x0, x1), std::min(y0, y1)), std::max(std::min(z0, z1), 0.0f));
    const float leave = std::min(std::min(std::max(x0, x1), std::max(y0, y1)), std::min(std::max(z0, z1), limit));
    return enter <= leave ? enter : 1e30f;
}

Vec3f inverse_of(Vec3f d)
{
    const auto invert = [](float x) { return 1.0f / (x == 0 ? 1e-20f : x); };
    return {invert(d.x), invert(d.y), invert(d.z)};
}

}  // namespace

float Caster::surface(const Bounds& box)
{
    const Vec3f d = box.high - box.low;
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

Caster::Caster(const Scene& scene) : scene_(&scene)
{
    for (std::size_t i = 1; i < scene.solids.size(); ++i)
        order_.push_back(static_cast<int>(i));
    nodes_.reserve(2 * order_.size() + 1);
    nodes_.emplace_back();
    build(0, 0, order_.size());
}

Caster::Bounds Caster::bounds(std::size_t begin, std::size_t end) const
{
    Bounds box;
    for (std::size_t i = begin; i < end; ++i)
    {
        const auto& solid = scene_->solids[static_cast<std::size_t>(order_[i])];
        const Vec3f half = half_extent(solid);
        box.low = lower(box.low, solid.center - half);
        box.high = upper(box.high, solid.center + half);
    }
    return box;
}

void Caster::sort_along(int axis, std::size_t begin, std::size_t end)
{
    const auto center = [&](int i) { return component(scene_->solids[static_cast<std::size_t>(i)].center, axis); };
    std::sort(order_.begin() + static_cast<std::ptrdiff_t>(begin), order_.begin() + static_cast<std::ptrdiff_t>(end),
              [&](int a, int b) { return center(a) != center(b) ? center(a) < center(b) : a < b; });
}

/// Splits where the sum of surface times solids is least (the surface area heuristic), trying every place along each axis.
void Caster::build(std::size_t node, std::size_t begin, std::size_t end)
{
    const auto box = bounds(begin, end);
    nodes_[node].low = box.low;
    nodes_[node].high = box.high;
    if (end - begin <= leaf_size)
    {
        nodes_[node].first = static_cast<int>(begin);
        nodes_[node].count = static_cast<int>(end - begin);
        return;
    }
    float least = 1e30f;
    int best_axis = 0;
    std::size_t best_split = (begin + end) / 2;
    for (int axis = 0; axis < 3; ++axis)
    {
        sort_along(axis, begin, end);
        for (std::size_t split = begin + 1; split < end; ++split)
        {
            const float cost = surface(bounds(begin, split)) * static_cast<float>(split - begin) +
                               surface(bounds(split, end)) * static_cast<float>(end - split);
            if (cost < least)
            {
                least = cost;
                best_axis = axis;
                best_split = split;
            }
        }
    }
    sort_along(best_axis, begin, end);
    const auto left = nodes_.size();
    nodes_[node].first = static_cast<int>(left);
    nodes_.resize(left + 2);
    build(left, begin, best_split);
    build(left + 1, best_split, end);
}

SceneHit Caster::cast(const Ray& ray, int guess) const
{
    const auto wall = intersect(scene_->solids[0], ray, 1e30f);
    SceneHit best{wall.face >= 0 ? wall.t : 1e30f, wall.face >= 0 ? 0 : -1, wall.face};
    if (guess > 0)
        if (const auto hit = intersect(scene_->solids[static_cast<std::size_t>(guess)], ray, best.t); hit.face >= 0)
            best = {hit.t, guess, hit.face};
    const Vec3f inverse = inverse_of(ray.direction);
    std::array<int, 64> stack{};
    std::size_t depth = 0;
    if (!order_.empty() && entry(nodes_[0].low, nodes_[0].high, ray.origin, inverse, best.t) < 1e30f)
        stack[depth++] = 0;
    while (depth > 0)
    {
        const Node& node = nodes_[static_cast<std::size_t>(stack[--depth])];
        if (node.count > 0)
        {
            for (int i = 0; i < node.count; ++i)
            {
                const int solid = order_[static_cast<std::size_t>(node.first + i)];
                if (const auto hit = intersect(scene_->solids[static_cast<std::size_t>(solid)], ray, best.t); hit.face >= 0)
                    best = {hit.t, solid, hit.face};
            }
            continue;
        }
        const auto left = static_cast<std::size_t>(node.first);
        const float near_left = entry(nodes_[left].low, nodes_[left].high, ray.origin, inverse, best.t);
        const float near_right = entry(nodes_[left + 1].low, nodes_[left + 1].high, ray.origin, inverse, best.t);
        const bool left_first = near_left <= near_right;
        if (std::max(near_left, near_right) < best.t)
            stack[depth++] = node.first + (left_first ? 1 : 0);
        if (std::min(near_left, near_right) < best.t)
            stack[depth++] = node.first + (left_first ? 0 : 1);
    }
    return best;
}

bool Caster::blocked(const Ray& ray, float limit, int ignored) const
{
    const Vec3f inverse = inverse_of(ray.direction);
    std::array<int, 64> stack{};
    std::size_t depth = 0;
    if (!order_.empty())
        stack[depth++] = 0;
    while (depth > 0)
    {
        const Node& node = nodes_[static_cast<std::size_t>(stack[--depth])];
        if (entry(node.low, node.high, ray.origin, inverse, limit) >= 1e30f)
            continue;
        if (node.count == 0)
        {
            stack[depth++] = node.first;
            stack[depth++] = node.first + 1;
            continue;
        }
        for (int i = 0; i < node.count; ++i)
        {
            const int solid = order_[static_cast<std::size_t>(node.first + i)];
            if (solid != ignored && intersect(scene_->solids[static_cast<std::size_t>(solid)], ray, limit).face >= 0)
                return true;
        }
    }
    return false;
}

}  // namespace room
