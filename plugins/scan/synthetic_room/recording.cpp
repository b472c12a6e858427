#include "recording.h"

#include "noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace room
{
namespace
{

using fresco::Vec3d;

constexpr float clearance = 0.22f;

/// OpenCV axes: z toward the target, y down, x right.
fresco::RigidTransform look_at(Vec3d eye, Vec3d target, double roll)
{
    const Vec3d forward = normalized(target - eye);
    const Vec3d level = normalized(cross(forward, Vec3d{0, 0, 1}));
    const Vec3d down = cross(forward, level);
    const Vec3d right = level * std::cos(roll) + down * std::sin(roll);
    const Vec3d below = down * std::cos(roll) - level * std::sin(roll);
    fresco::RigidTransform pose;
    pose.rotation.m = {right.x, below.x, forward.x, right.y, below.y, forward.y, right.z, below.z, forward.z};
    pose.translation = eye;
    return pose;
}

/// Toward the middle of the room, between table and lamp, until nothing is near.
Vec3d kept_clear(const Scene& scene, Vec3d eye)
{
    const Vec3d middle{scene.size.x / 2.0, scene.size.y / 2.0, 1.33};
    for (int step = 0; step < 80 && free_distance(scene, fresco::vec_cast<float>(eye)) < clearance; ++step)
        eye = eye + (middle - eye) * 0.05;
    return eye;
}

}  // namespace

Recorder make_recorder(int color_width, int color_height, int depth_width, int depth_height)
{
    const double color_focal = 1.06 * color_height, depth_focal = 1.18 * depth_height;
    Recorder recorder;
    recorder.color = {color_width, color_height, color_focal, color_focal, 0.502 * color_width, 0.496 * color_height};
    recorder.depth = {depth_width, depth_height, depth_focal, depth_focal, 0.5 * depth_width, 0.5 * depth_height};
    const double turn = 0.4 * std::numbers::pi / 180;
    recorder.color_from_depth.rotation.m = {std::cos(turn), 0, std::sin(turn), 0, 1, 0, -std::sin(turn), 0, std::cos(turn)};
    recorder.color_from_depth.translation = {-0.025, 0.0, 0.002};
    return recorder;
}

std::vector<fresco::RigidTransform> camera_path(const Scene& scene, int count, std::uint32_t seed)
{
    const double l = static_cast<double>(scene.size.x), w = static_cast<double>(scene.size.y);
    const int across = (count + 1) / 2;
    std::vector<fresco::RigidTransform> poses;
    for (int i = 0; i < count; ++i)
    {
        const bool first_round = i < across;
        const int steps = first_round ? across : count - across, step = first_round ? i : i - across;
        const double turn = 2 * std::numbers::pi * (step + (first_round ? 0.0 : 0.5)) / steps;
        const auto jitter = [&](std::uint32_t what)
        { return static_cast<double>(bell(hash(seed, hash(static_cast<std::uint32_t>(i), what)))); };
        const double reach = first_round ? 0.36 : -0.12;
        const Vec3d eye{l * (0.5 + reach * std::cos(turn)) + 0.03 * jitter(1),
                        w * (0.5 + reach * std::sin(turn)) + 0.03 * jitter(2),
                        1.42 + (first_round ? 0.26 : 0.20) * std::sin(3 * turn) + 0.02 * jitter(3)};
        // Across: past the middle, at table height. Along the wall: down to the floor. Outward: at the walls, up and down.
        const bool along_wall = first_round && step % 4 == 3;
        const double sway = along_wall ? 1.1 : first_round ? 0.35 * std::sin(5 * turn) : 0.0;
        const double aim = along_wall ? 0.40 : first_round ? -0.20 : 0.50;
        const double height = along_wall    ? 0.1
                              : first_round ? 0.75 + 0.35 * std::sin(4 * turn + 1)
                                            : 1.10 + 1.6 * std::sin(7 * turn + 0.7);
        const Vec3d target{l * (0.5 + aim * std::cos(turn + sway)), w * (0.5 + aim * std::sin(turn + sway)), height};
        poses.push_back(look_at(kept_clear(scene, eye), target, 0.02 * jitter(4)));
    }
    return poses;
}

namespace
{

constexpr float color_noise = 1.1f;
constexpr float nearest_m = 0.3f, farthest_m = 10.0f;
constexpr float silhouette_m = 0.06f;

/// Rays whose distance is depth along the optical axis.
class Rays
{
  public:
    explicit Rays(const fresco::Camera& camera)
        : origin_(fresco::vec_cast<float>(camera.world_from_camera.translation)),
          start_(fresco::vec_cast<float>(camera.ray(0, 0))), right_(fresco::vec_cast<float>(camera.ray(1, 0) - camera.ray(0, 0))),
          down_(fresco::vec_cast<float>(camera.ray(0, 1) - camera.ray(0, 0)))
    {
    }
    Ray at(float x, float y) const { return {origin_, start_ + right_ * x + down_ * y}; }

  private:
    Vec3f origin_, start_, right_, down_;
};

/// One color sample, in linear steps of display value.
Vec3f sample(const Caster& caster, const LightMap& light, const Ray& ray, const SceneHit& hit, float meters_per_pixel)
{
    if (hit.solid < 0)
        return {};
    const auto& solid = caster.scene().solids[static_cast<std::size_t>(hit.solid)];
    const Vec2f where = face_coordinates(solid, hit.face, ray.origin + ray.direction * hit.t);
    return light.shade(hit.solid, hit.face, where, 0.5f * hit.t * meters_per_pixel);
}

/// Intersects a ray with a face that the rays around it hit. A box's face is convex, so only its plane is intersected.
Hit hit_again(const Solid& solid, const SceneHit& around, const Ray& ray)
{
    if (solid.shape != Shape::box)
        return intersect(solid, ray, 1e30f);
    const auto axis = static_cast<std::size_t>(around.face / 2);
    const float half = axis == 0 ? solid.size.x : axis == 1 ? solid.size.y : solid.size.z;
    const float plane = around.face % 2 == 0 ? -half : half;
    return {(plane - dot(solid.axes[axis], ray.origin - solid.center)) / dot(solid.axes[axis], ray.direction), around.face};
}

/// Intersects a ray with the face that all corners of a block show (`shared`), or with the whole scene if `shared` is null.
SceneHit subpixel_hit(const Caster& caster, const Ray& ray, const SceneHit* shared, int guess)
{
    if (shared != nullptr && shared->solid >= 0)
        if (const auto hit = hit_again(caster.scene().solids[static_cast<std::size_t>(shared->solid)], *shared, ray);
            hit.face == shared->face)
            return {hit.t, shared->solid, hit.face};
    return caster.cast(ray, guess);
}

}  // namespace

fresco::Raster<std::uint8_t> render_color(const Caster& caster, const LightMap& light, const fresco::Camera& camera,
                                          std::uint32_t seed)
{
    const int width = camera.intrinsics.width, height = camera.intrinsics.height;
    const auto meters_per_pixel = static_cast<float>(1 / camera.intrinsics.fx);
    const Rays rays(camera);
    // Corners of blocks of 2 x 2 pixels.
    const auto corner_row = [&](int y)
    {
        std::vector<SceneHit> row;
        for (int x = 0; x < width + 2; x += 2)
            row.push_back(caster.cast(rays.at(static_cast<float>(x), static_cast<float>(y)), x > 0 ? row.back().solid : -1));
        return row;
    };
    fresco::Raster<std::uint8_t> picture(width, height, 3);
    std::vector<SceneHit> above, below = corner_row(0);
    for (int y = 0; y < height; ++y)
    {
        if (y % 2 == 0)
            above = std::exchange(below, corner_row(y + 2));
        for (int x = 0; x < width; ++x)
        {
            const auto i = static_cast<std::size_t>(x / 2);
            const bool same =
                above[i].same_face(above[i + 1]) && above[i].same_face(below[i]) && above[i].same_face(below[i + 1]);
            constexpr std::array places{Vec2f{0.25f, 0.25f}, Vec2f{0.75f, 0.75f}, Vec2f{0.25f, 0.75f}, Vec2f{0.75f, 0.25f}};
            // Within a face, the diagonal is as smooth as all.
            const auto samples = std::span(places).first(same ? 2 : 4);
            Vec3f sum;
            for (const Vec2f at : samples)
            {
                const Ray ray = rays.at(static_cast<float>(x) + at.x, static_cast<float>(y) + at.y);
                sum += sample(caster, light, ray, subpixel_hit(caster, ray, same ? &above[i] : nullptr, above[i].solid),
                              meters_per_pixel);
            }
            const auto pixel_seed = lattice(x, y, seed);
            const float noise = color_noise * bell(pixel_seed);
            const auto store = [&](int channel, float value)
            {
                const float level = 255 * value / static_cast<float>(samples.size()) + noise;
                picture.at(x, y, channel) = static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
            };
            store(0, sum.x);
            store(1, sum.y);
            store(2, sum.z);
        }
    }
    return picture;
}

fresco::Raster<float> render_depth(const Caster& caster, const fresco::Camera& camera)
{
    const Rays rays(camera);
    fresco::Raster<float> depth(camera.intrinsics.width, camera.intrinsics.height);
    for (int y = 0; y < depth.height; ++y)
    {
        int guess = -1;
        for (int x = 0; x < depth.width; ++x)
        {
            const auto hit = caster.cast(rays.at(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f), guess);
            depth.at(x, y) = hit.solid >= 0 ? hit.t : 0.0f;
            guess = hit.solid;
        }
    }
    return depth;
}

fresco::Raster<std::uint16_t> sense_depth(const fresco::Raster<float>& exact, float noise_m, std::uint32_t seed)
{
    fresco::Raster<std::uint16_t> sensed(exact.width, exact.height);
    for (int y = 0; y < exact.height; ++y)
        for (int x = 0; x < exact.width; ++x)
        {
            const float z = exact.at(x, y);
            if (z < nearest_m || z > farthest_m)
                continue;
            const float left = x > 0 ? exact.at(x - 1, y) : z;
            const auto pixel_seed = lattice(x, y, seed);
            // The projector stands beside the camera: what is left of a nearer edge lies in its shadow.
            if (left + silhouette_m < z && unit(pixel_seed, 9u) < 0.7f)
                continue;
            const float sigma = noise_m * (0.3f + 0.17f * z * z);
            sensed.at(x, y) = static_cast<std::uint16_t>(std::lround(1000 * (z + sigma * bell(pixel_seed))));
        }
    return sensed;
}

}  // namespace room
