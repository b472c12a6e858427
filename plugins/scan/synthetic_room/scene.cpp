#include "scene.h"

#include <algorithm>
#include <cmath>

namespace room
{
namespace
{

constexpr float least_t = 1e-4f;

Hit hit_box(const Solid& solid, Vec3f o, Vec3f d, float limit)
{
    const std::array<float, 3> origin{o.x, o.y, o.z}, direction{d.x, d.y, d.z}, half{solid.size.x, solid.size.y, solid.size.z};
    float enter = -1e30f, leave = 1e30f;
    int enter_face = -1, leave_face = -1;
    for (int axis = 0; axis < 3; ++axis)
    {
        const auto a = static_cast<std::size_t>(axis);
        const float inverse = 1.0f / (direction[a] == 0 ? 1e-20f : direction[a]);
        const float low = (-half[a] - origin[a]) * inverse, high = (half[a] - origin[a]) * inverse;
        const bool forward = inverse > 0;
        if (const float near = forward ? low : high; near > enter)
            enter = near, enter_face = 2 * axis + (forward ? 0 : 1);
        if (const float far = forward ? high : low; far < leave)
            leave = far, leave_face = 2 * axis + (forward ? 1 : 0);
    }
    if (enter > leave)
        return {};
    if (!solid.hollow && enter > least_t)
        return enter < limit ? Hit{enter, enter_face} : Hit{};
    return leave > least_t && leave < limit ? Hit{leave, leave_face} : Hit{};
}

Hit hit_frustum(const Solid& solid, Vec3f o, Vec3f d, float limit)
{
    const float height = solid.size.z;
    const float middle = 0.5f * (solid.size.x + solid.size.y), slope = (solid.size.y - solid.size.x) / (2 * height);
    Hit best;
    best.t = limit;
    const auto offer = [&](float t, int face)
    {
        if (t > least_t && t < best.t)
            best = {t, face};
    };
    const float a = d.x * d.x + d.y * d.y - slope * slope * d.z * d.z;
    const float b = o.x * d.x + o.y * d.y - slope * d.z * (middle + slope * o.z);
    const float c = o.x * o.x + o.y * o.y - (middle + slope * o.z) * (middle + slope * o.z);
    if (const float root = b * b - a * c; root > 0 && std::abs(a) > 1e-12f)
        for (const float sign : {-1.0f, 1.0f})
        {
            const float t = (-b + sign * std::sqrt(root)) / a;
            const float z = o.z + t * d.z;
            if (std::abs(z) <= height && middle + slope * z >= 0)
                offer(t, 0);
        }
    if (d.z != 0)
        for (const int end : {1, 2})
        {
            const float t = ((end == 2 ? height : -height) - o.z) / d.z;
            const float x = o.x + t * d.x, y = o.y + t * d.y, radius = end == 2 ? solid.size.y : solid.size.x;
            if (x * x + y * y <= radius * radius)
                offer(t, end);
        }
    return best.face >= 0 ? best : Hit{};
}

Hit hit_ellipsoid(const Solid& solid, Vec3f o, Vec3f d, float limit)
{
    const Vec3f p{o.x / solid.size.x, o.y / solid.size.y, o.z / solid.size.z};
    const Vec3f q{d.x / solid.size.x, d.y / solid.size.y, d.z / solid.size.z};
    const float a = dot(q, q), b = dot(p, q), c = dot(p, p) - 1;
    const float root = b * b - a * c;
    if (root <= 0)
        return {};
    for (const float sign : {-1.0f, 1.0f})
        if (const float t = (-b + sign * std::sqrt(root)) / a; t > least_t)
            return t < limit ? Hit{t, 0} : Hit{};
    return {};
}

float box_distance(Vec3f p, Vec3f half)
{
    const Vec3f q{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
    const Vec3f outside{std::max(q.x, 0.0f), std::max(q.y, 0.0f), std::max(q.z, 0.0f)};
    return length(outside) + std::min(std::max({q.x, q.y, q.z}), 0.0f);
}

float segment_distance(Vec2f p, Vec2f a, Vec2f b)
{
    const Vec2f ab = b - a;
    const float squared = dot(ab, ab);
    const float t = squared > 0 ? std::clamp(dot(p - a, ab) / squared, 0.0f, 1.0f) : 0.0f;
    return length(p - (a + ab * t));
}

/// The frustum's half profile is a quadrilateral in (radius, z).
float frustum_distance(Vec3f p, Vec3f size)
{
    const Vec2f q{std::sqrt(p.x * p.x + p.y * p.y), p.z};
    const Vec2f low{size.x, -size.z}, high{size.y, size.z};
    const float distance = std::min(
        {segment_distance(q, {0, -size.z}, low), segment_distance(q, low, high), segment_distance(q, high, {0, size.z})});
    const float radius = 0.5f * (size.x + size.y) + (size.y - size.x) / (2 * size.z) * q.y;
    return std::abs(q.y) <= size.z && q.x <= radius ? -distance : distance;
}

float ellipsoid_distance(Vec3f p, Vec3f r)
{
    const float k0 = length(Vec3f{p.x / r.x, p.y / r.y, p.z / r.z});
    const float k1 = length(Vec3f{p.x / (r.x * r.x), p.y / (r.y * r.y), p.z / (r.z * r.z)});
    return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({r.x, r.y, r.z});
}

FacePoint local_point(const Solid& solid, int face, Vec2f c)
{
    const Vec3f s = solid.size;
    if (solid.shape == Shape::box)
    {
        const float side = face % 2 == 0 ? -1.0f : 1.0f, outward = solid.hollow ? -side : side;
        switch (face / 2)
        {
        case 0:
            return {{side * s.x, c.x - s.y, c.y - s.z}, {outward, 0, 0}};
        case 1:
            return {{c.x - s.x, side * s.y, c.y - s.z}, {0, outward, 0}};
        default:
            return {{c.x - s.x, c.y - s.y, side * s.z}, {0, 0, outward}};
        }
    }
    if (solid.shape == Shape::frustum && face > 0)
    {
        const float radius = face == 1 ? s.x : s.y, side = face == 1 ? -1.0f : 1.0f;
        return {{c.x - radius, c.y - radius, side * s.z}, {0, 0, side}};
    }
    const float angle = c.x / std::max(s.x, s.y) - pi, cosine = std::cos(angle), sine = std::sin(angle);
    if (solid.shape == Shape::frustum)
    {
        const float z = c.y - s.z, slope = (s.y - s.x) / (2 * s.z), radius = 0.5f * (s.x + s.y) + slope * z;
        return {{radius * cosine, radius * sine, z}, normalized(Vec3f{cosine, sine, -slope})};
    }
    const float latitude = c.y / s.z - pi / 2;
    const Vec3f sphere{std::cos(latitude) * cosine, std::cos(latitude) * sine, std::sin(latitude)};
    return {{sphere.x * s.x, sphere.y * s.y, sphere.z * s.z}, normalized(Vec3f{sphere.x / s.x, sphere.y / s.y, sphere.z / s.z})};
}

}  // namespace

Hit intersect(const Solid& solid, const Ray& ray, float limit)
{
    const Vec3f o = solid.to_local(ray.origin - solid.center), d = solid.to_local(ray.direction);
    switch (solid.shape)
    {
    case Shape::box:
        return hit_box(solid, o, d, limit);
    case Shape::frustum:
        return hit_frustum(solid, o, d, limit);
    case Shape::ellipsoid:
        return hit_ellipsoid(solid, o, d, limit);
    }
    return {};
}

float signed_distance(const Solid& solid, Vec3f world_point)
{
    const Vec3f p = solid.to_local(world_point - solid.center);
    switch (solid.shape)
    {
    case Shape::box:
        return solid.hollow ? -box_distance(p, solid.size) : box_distance(p, solid.size);
    case Shape::frustum:
        return frustum_distance(p, solid.size);
    case Shape::ellipsoid:
        return ellipsoid_distance(p, solid.size);
    }
    return 0;
}

Vec3f half_extent(const Solid& solid)
{
    const float radius = std::max(solid.size.x, solid.size.y);
    const Vec3f half = solid.shape == Shape::frustum ? Vec3f{radius, radius, solid.size.z} : solid.size;
    const auto& a = solid.axes;
    return {std::abs(a[0].x) * half.x + std::abs(a[1].x) * half.y + std::abs(a[2].x) * half.z,
            std::abs(a[0].y) * half.x + std::abs(a[1].y) * half.y + std::abs(a[2].y) * half.z,
            std::abs(a[0].z) * half.x + std::abs(a[1].z) * half.y + std::abs(a[2].z) * half.z};
}

Vec2f face_extent(const Solid& solid, int face)
{
    const Vec3f s = solid.size;
    if (solid.shape == Shape::box)
        return face < 2 ? Vec2f{2 * s.y, 2 * s.z} : face < 4 ? Vec2f{2 * s.x, 2 * s.z} : Vec2f{2 * s.x, 2 * s.y};
    const float around = 2 * pi * std::max(s.x, s.y);
    if (solid.shape == Shape::ellipsoid)
        return {around, pi * s.z};
    return face == 0 ? Vec2f{around, 2 * s.z} : face == 1 ? Vec2f{2 * s.x, 2 * s.x} : Vec2f{2 * s.y, 2 * s.y};
}

Vec2f face_coordinates(const Solid& solid, int face, Vec3f world_point)
{
    const Vec3f p = solid.to_local(world_point - solid.center), s = solid.size;
    if (solid.shape == Shape::box)
        return face < 2 ? Vec2f{p.y + s.y, p.z + s.z} : face < 4 ? Vec2f{p.x + s.x, p.z + s.z} : Vec2f{p.x + s.x, p.y + s.y};
    if (solid.shape == Shape::frustum && face > 0)
    {
        const float radius = face == 1 ? s.x : s.y;
        return {p.x + radius, p.y + radius};
    }
    const float scale = std::max(s.x, s.y);
    if (solid.shape == Shape::frustum)
        return {(std::atan2(p.y, p.x) + pi) * scale, p.z + s.z};
    return {(std::atan2(p.y / s.y, p.x / s.x) + pi) * scale, (std::asin(std::clamp(p.z / s.z, -1.0f, 1.0f)) + pi / 2) * s.z};
}

FacePoint face_point(const Solid& solid, int face, Vec2f coordinates)
{
    const auto local = local_point(solid, face, coordinates);
    return {solid.center + solid.to_world(local.position), solid.to_world(local.normal)};
}

int nearest_face(const Solid& solid, Vec3f world_point)
{
    const Vec3f p = solid.to_local(world_point - solid.center), s = solid.size;
    if (solid.shape == Shape::ellipsoid)
        return 0;
    if (solid.shape == Shape::frustum)
    {
        const float radius = std::sqrt(p.x * p.x + p.y * p.y);
        const float side = radius - (0.5f * (s.x + s.y) + (s.y - s.x) / (2 * s.z) * p.z), cap = std::abs(p.z) - s.z;
        return side > cap ? 0 : p.z < 0 ? 1 : 2;
    }
    const std::array<float, 3> beyond{std::abs(p.x) - s.x, std::abs(p.y) - s.y, std::abs(p.z) - s.z};
    const std::array<float, 3> side{p.x, p.y, p.z};
    const auto axis = static_cast<std::size_t>(std::max_element(beyond.begin(), beyond.end()) - beyond.begin());
    return 2 * static_cast<int>(axis) + (side[axis] > 0 ? 1 : 0);
}

namespace
{

constexpr std::size_t leaf_size = 2;

float component(Vec3f v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// Distance at which a ray enters a box, or a large number if it misses the box or enters it beyond `limit`.
[[gnu::always_inline]] inline float entry(const fresco::numerics::Bounds<float>& box, const Vec3f& origin, const Vec3f& inverse,
                                          float limit)
{
    const auto& [low, high] = box;
    const float x0 = (low.x - origin.x) * inverse.x, x1 = (high.x - origin.x) * inverse.x;
    const float y0 = (low.y - origin.y) * inverse.y, y1 = (high.y - origin.y) * inverse.y;
    const float z0 = (low.z - origin.z) * inverse.z, z1 = (high.z - origin.z) * inverse.z;
    const float enter = std::max(std::max(std::min(x0, x1), std::min(y0, y1)), std::max(std::min(z0, z1), 0.0f));
    const float leave = std::min(std::min(std::max(x0, x1), std::max(y0, y1)), std::min(std::max(z0, z1), limit));
    return enter <= leave ? enter : 1e30f;
}

float surface(const fresco::numerics::Bounds<float>& box)
{
    const Vec3f d = box.high - box.low;
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

Vec3f inverse_of(Vec3f d)
{
    const auto invert = [](float x) { return 1.0f / (x == 0 ? 1e-20f : x); };
    return {invert(d.x), invert(d.y), invert(d.z)};
}

}  // namespace

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
        box.add(solid.center - half);
        box.add(solid.center + half);
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
    nodes_[node].box = bounds(begin, end);
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
    if (!order_.empty() && entry(nodes_[0].box, ray.origin, inverse, best.t) < 1e30f)
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
        const float near_left = entry(nodes_[left].box, ray.origin, inverse, best.t);
        const float near_right = entry(nodes_[left + 1].box, ray.origin, inverse, best.t);
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
        if (entry(node.box, ray.origin, inverse, limit) >= 1e30f)
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

float free_distance(const Scene& scene, Vec3f point)
{
    float distance = 1e9f;
    for (const auto& solid : scene.solids)
        distance = std::min(distance, signed_distance(solid, point));
    return distance;
}

}  // namespace room
