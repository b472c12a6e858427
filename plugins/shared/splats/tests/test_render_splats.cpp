#include "catch.h"

#include <fresco/splats/render_splats.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>
#include <numeric>

using namespace fresco;
using namespace fresco::splats;

namespace
{

constexpr double nearest_m = 0.1;

Camera camera_at_origin()
{
    return {{75, 50, 60, 55, 36, 27}, {}};
}

void add(Splats& splats, Vec3f center, Vec3f scale, float opacity, Vec3f color, std::array<float, 4> rotation = {1, 0, 0, 0})
{
    splats.centers.push_back(center);
    splats.scales.push_back(scale);
    splats.opacities.push_back(opacity);
    splats.colors.push_back(color);
    splats.rotations.push_back(rotation);
}

/// Round, flat and long ones of all sizes, in front of the camera, beside, behind and around it.
Splats heap(std::size_t count)
{
    Splats splats;
    std::uint32_t state = 7;
    const auto random = [&](double low, double high)
    {
        state = state * 1664525U + 1013904223U;
        return static_cast<float>(low + (high - low) * (state >> 8U) / 16777216.0);
    };
    for (std::size_t i = 0; i < count; ++i)
    {
        std::array<float, 4> q{random(-1, 1), random(-1, 1), random(-1, 1), random(-1, 1)};
        const float norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (float& part : q)
            part /= norm;
        const auto scale = [&] { return std::exp(random(-7, -1.2)); };
        add(splats, {random(-2, 2), random(-2, 2), random(-0.5, 4)}, {scale(), scale(), scale()}, random(0, 1),
            {random(-0.2, 1.5), random(0, 1), random(0, 1)}, q);
    }
    return splats;
}

/// The slow twin: every pixel on its own, all Gaussians in order of depth, in doubles, by the formulas of the paper.
struct SlowPixel
{
    Vec3d color;
    double through = 1;
    double depth = 0;
    double margin =
        1;  ///< How far the transmittance stays from one half: nearer, rounding decides which Gaussian's depth counts.
};

/// Nearest first.
std::vector<std::size_t> by_depth(const Splats& splats, const Camera& camera)
{
    const RigidTransform camera_from_world = camera.world_from_camera.inverse();
    std::vector<std::size_t> order(splats.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {},
                             [&](std::size_t i)
                             { return static_cast<float>(camera_from_world.point(vec_cast<double>(splats.centers[i])).z); });
    return order;
}

SlowPixel slow_pixel(const Splats& splats, const std::vector<std::size_t>& order, const Camera& camera, double x, double y)
{
    const RigidTransform camera_from_world = camera.world_from_camera.inverse();
    const Intrinsics& lens = camera.intrinsics;
    SlowPixel pixel;
    for (const std::size_t i : order)
    {
        const Vec3d c = camera_from_world.point(vec_cast<double>(splats.centers[i]));
        if (c.z <= nearest_m)
            continue;
        const auto& q = splats.rotations[i];
        const double w = static_cast<double>(q[0]), qx = static_cast<double>(q[1]), qy = static_cast<double>(q[2]),
                     qz = static_cast<double>(q[3]);
        Mat3 m{{1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - w * qz), 2 * (qx * qz + w * qy), 2 * (qx * qy + w * qz),
                1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - w * qx), 2 * (qx * qz - w * qy), 2 * (qy * qz + w * qx),
                1 - 2 * (qx * qx + qy * qy)}};
        m = camera_from_world.rotation * m;
        const Vec3d s = vec_cast<double>(splats.scales[i]);
        const Mat3 scale{{s.x * s.x, 0, 0, 0, s.y * s.y, 0, 0, 0, s.z * s.z}};
        const Mat3 covariance = m * scale * transposed(m);
        const double limit_x = 1.3 * lens.width / (2 * lens.fx), limit_y = 1.3 * lens.height / (2 * lens.fy);
        const double tx = std::clamp(c.x / c.z, -limit_x, limit_x), ty = std::clamp(c.y / c.z, -limit_y, limit_y);
        // The rows of J: x and y in the picture, and depth.
        const Mat3 jacobian{{lens.fx / c.z, 0, -lens.fx * tx / c.z, 0, lens.fy / c.z, -lens.fy * ty / c.z, 0, 0, 1}};
        const Mat3 seen = jacobian * covariance * transposed(jacobian);
        const double xx = seen(0, 0) + 0.3, yy = seen(1, 1) + 0.3, xy = seen(0, 1), det = xx * yy - xy * xy;
        const double dx = x - (lens.fx * c.x / c.z + lens.cx), dy = y - (lens.fy * c.y / c.z + lens.cy);
        const double alpha = std::min(0.99, static_cast<double>(splats.opacities[i]) *
                                                std::exp(-0.5 * (yy * dx * dx - 2 * xy * dx * dy + xx * dy * dy) / det));
        if (alpha < 1.0 / 255)
            continue;
        pixel.color += vec_cast<double>(splats.colors[i]) * (alpha * pixel.through);
        const double after = pixel.through * (1 - alpha);
        if (pixel.through >= 0.5 && after < 0.5)
            pixel.depth = c.z + (seen(2, 0) * (yy * dx - xy * dy) + seen(2, 1) * (xx * dy - xy * dx)) / det;
        pixel.through = after;
        pixel.margin = std::min(pixel.margin, std::abs(after - 0.5));
    }
    return pixel;
}

}  // namespace

TEST_CASE("pictures of splats are those of the slow twin", "[splats]")
{
    const Splats splats = heap(2000);
    Camera camera = camera_at_origin();
    camera.world_from_camera.rotation = {{0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8}};
    camera.world_from_camera.translation = {-0.4, 0.1, 0};
    testing::TestRun run;
    const SplatPicture picture = render_splats(splats, camera, nearest_m, run);
    const auto order = by_depth(splats, camera);
    int with_depth = 0, apart = 0;
    for (int y = 0; y < picture.depth.height; ++y)
        for (int x = 0; x < picture.depth.width; ++x)
        {
            const SlowPixel slow = slow_pixel(splats, order, camera, x + 0.5, y + 0.5);
            const Vec3d color{static_cast<double>(picture.color.at(x, y, 0)), static_cast<double>(picture.color.at(x, y, 1)),
                              static_cast<double>(picture.color.at(x, y, 2))};
            // Rounding may add or leave out a Gaussian that is as faint as 1/255 there.
            const bool same = std::abs(static_cast<double>(picture.transmittance.at(x, y)) - slow.through) < 1e-3 &&
                              length(color - slow.color) < 2e-3;
            apart += same ? 0 : 1;
            if (slow.margin > 1e-3 && same)
            {
                INFO(x << ' ' << y);
                REQUIRE(std::abs(static_cast<double>(picture.depth.at(x, y)) - slow.depth) < 1e-3);
                with_depth += slow.depth > 0 ? 1 : 0;
            }
        }
    CHECK(apart <= 75 * 50 / 200);
    CHECK(with_depth > 75 * 50 / 2);
}

TEST_CASE("the depth of a flat, slanted splat is that of its plane", "[splats]")
{
    Splats splats;
    // Turned by 45 degrees about y: the plane x + z = 3.
    const float cosine = std::cos(0.3926991F), sine = std::sin(0.3926991F);
    add(splats, {0, 0, 3}, {0.3F, 0.3F, 0.001F}, 1, {1, 0.5F, 0}, {cosine, 0, sine, 0});
    testing::TestRun run;
    const Camera camera = camera_at_origin();
    const SplatPicture picture = render_splats(splats, camera, nearest_m, run);
    int measured = 0;
    for (int x = 0; x < camera.intrinsics.width; ++x)
        if (const auto depth = static_cast<double>(picture.depth.at(x, 27)); depth > 0)
        {
            // The footprint is linear, perspective is not: they part with the square of the distance from the center.
            const double slope = (x + 0.5 - camera.intrinsics.cx) / camera.intrinsics.fx;
            CHECK(std::abs(depth - 3 / (1 + slope)) < 0.02 + 3 * slope * slope);
            ++measured;
        }
    CHECK(measured >= 6);
    CHECK(picture.color.at(36, 27, 0) > 0.9F);
    CHECK(picture.transmittance.at(36, 27) < 0.1F);
    CHECK(picture.transmittance.at(0, 0) == 1);
    CHECK(picture.depth.at(0, 0) == 0);
}

TEST_CASE("pictures of splats are the same for any number of threads", "[splats]")
{
    const Splats splats = heap(9000);
    testing::TestRun one(1), four(4);
    const SplatPicture a = render_splats(splats, camera_at_origin(), nearest_m, one);
    const SplatPicture b = render_splats(splats, camera_at_origin(), nearest_m, four);
    CHECK((a.color == b.color && a.transmittance == b.transmittance && a.depth == b.depth));
    CHECK(std::ranges::all_of(a.transmittance.values, [](float through) { return through >= 0 && through <= 1; }));
}

TEST_CASE("splats behind the camera and nearer than the limit are not drawn", "[splats]")
{
    Splats splats;
    add(splats, {0, 0, -1}, {0.1F, 0.1F, 0.1F}, 1, {1, 1, 1});
    add(splats, {0, 0, 0.09F}, {0.1F, 0.1F, 0.1F}, 1, {1, 1, 1});
    testing::TestRun run;
    SplatPicture picture = render_splats(splats, camera_at_origin(), nearest_m, run);
    CHECK(std::ranges::all_of(picture.transmittance.values, [](float through) { return through == 1; }));
    splats.centers.back().z = 0.11F;
    picture = render_splats(splats, camera_at_origin(), nearest_m, run);
    CHECK(picture.transmittance.at(36, 27) < 0.02F);
}

TEST_CASE("splats much larger than the picture stay within it", "[splats]")
{
    Splats splats;
    for (int i = 0; i < 300; ++i)
    {
        const float turn = 0.01F * static_cast<float>(i), size = std::pow(10.0F, static_cast<float>(i % 12));
        const std::array<float, 4> rotation{std::cos(turn), 0, 0.6F * std::sin(turn), 0.8F * std::sin(turn)};
        add(splats, {0.1F, 0.2F, 0.5F + 0.01F * static_cast<float>(i)}, {size, 0.02F, 1e-4F}, 0.03F, {0.5F, 0.5F, 0.5F},
            rotation);
    }
    testing::TestRun run;
    const Camera camera = camera_at_origin();
    const SplatPicture picture = render_splats(splats, camera, nearest_m, run);
    CHECK(std::ranges::all_of(picture.transmittance.values, [](float through) { return through >= 0 && through <= 1; }));
    CHECK(std::ranges::all_of(picture.color.values, [](float value) { return value >= 0 && value <= 0.5F; }));
    const float most = *std::ranges::min_element(picture.transmittance.values);
    CHECK(most < 0.9F);
}
