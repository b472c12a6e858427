#include "catch.h"
#include "integration.h"
#include "room.h"

#include <fresco/numerics/numerics.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

using namespace fresco;

namespace
{

constexpr int width = 64;
constexpr int height = 48;

std::size_t believed(const fuse::DepthView& view)
{
    std::size_t count = 0;
    for (const fuse::PixelPlane& plane : view.planes.values)
        count += plane.weight > 0 ? 1 : 0;
    return count;
}

}  // namespace

TEST_CASE("invalid depth, or depth too far or at the border, is ignored")
{
    const Camera camera{{width, height, 60, 61, 31, 25}, {}};
    RasterF depth(width, height, 1, 2);
    const float infinite = std::numeric_limits<float>::infinity();
    depth.at(20, 20) = 0;
    depth.at(30, 20) = -1;
    depth.at(40, 20) = infinite;
    depth.at(50, 20) = std::numeric_limits<float>::quiet_NaN();
    depth.at(20, 30) = 5.1F;
    const fuse::DepthView view = fuse::depth_view(depth, camera, 5);
    // Pixels without depth are bridged, those around them count less.
    CHECK(believed(view) == static_cast<std::size_t>((width - 2) * (height - 2)));
    for (const int x : {20, 30, 40, 50})
    {
        CHECK(view.depth.at(x, 20) == Approx(2));
        CHECK(view.planes.at(x, 20).weight < 0.26F * view.planes.at(x, 24).weight);
    }
    CHECK(view.depth.at(0, 20) == 0);
    CHECK(view.depth.at(1, 20) == 2);
    CHECK(believed(fuse::depth_view(depth, camera, 1.9)) == 0);
}

namespace
{

constexpr double voxel_m = 0.03;
constexpr double truncation_m = 0.1;

/// The room with a pillar in it, seen from its middle.
struct Recorded
{
    Camera camera;
    RasterF depth;
};

Recorded recorded(double angle)
{
    Recorded result{test_room::camera_at(angle, 120), {}};
    // No voxel falls on the line between two pixels.
    result.camera.world_from_camera.translation += Vec3d{0.1 * angle + 0.0123, 0.0077, 0.0031};
    result.depth = test_room::depth_of(result.camera);
    for (int y = 0; y < result.depth.height; ++y)
        for (int x = 50; x < 70; ++x)
            result.depth.at(x, y) = (x + 2 * y) % 7 == 0 ? 0.0F : 0.7F + 0.001F * static_cast<float>((x * 7 + y * 3) % 5);
    return result;
}

std::vector<fuse::DepthView> views()
{
    std::vector<fuse::DepthView> result;
    for (const double angle : {0.0, 0.3, 1.1, 2.0, 3.3, 4.4})
    {
        const Recorded one = recorded(angle);
        result.push_back(fuse::depth_view(one.depth, one.camera, 1.6));
    }
    return result;
}

fuse::Volume opened(const std::vector<fuse::DepthView>& views)
{
    std::vector<fuse::BlockPlace> places;
    for (const fuse::DepthView& view : views)
        fuse::unite(places, fuse::OpenedBlocks{voxel_m, truncation_m, 100'000}.near(view));
    return {voxel_m, places};
}

Vec3d voxel_position(const fuse::BlockPlace& place, std::size_t index)
{
    const auto i = static_cast<int>(index);
    return Vec3d{static_cast<double>(8 * place.x + i % 8), static_cast<double>(8 * place.y + i / 8 % 8),
                 static_cast<double>(8 * place.z + i / 64)} *
           voxel_m;
}

/// One voxel at a time, in double precision, as the rules say; planes by normal equations.
struct SlowVoxel
{
    double sum = 0;
    double weight = 0;
};

class SlowView
{
  public:
    SlowView(const Recorded& recorded, double max_depth_m) : camera_(recorded.camera), depth_(recorded.depth)
    {
        for (float& z : depth_.values)
            if (!(z > 0) || double{z} > max_depth_m)
                z = 0;
    }

    void add(Vec3d point, SlowVoxel& voxel)
    {
        const Vec3d seen = camera_.project(point);
        if (!(seen.z > 0) || seen.x < 0 || seen.y < 0 || seen.x >= depth_.width || seen.y >= depth_.height)
            return;
        const Plane& plane = plane_at(static_cast<int>(seen.x), static_cast<int>(seen.y));
        const double distance = dot(point, plane.normal) - plane.offset;
        if (plane.weight == 0 || distance <= -truncation_m)
            return;
        const double share = distance >= -voxel_m ? 1 : (truncation_m + distance) / (truncation_m - voxel_m);
        voxel.sum += plane.weight * share * std::min(distance, truncation_m);
        voxel.weight += plane.weight * share;
    }

  private:
    struct Plane
    {
        Vec3d normal;  ///< In the world, toward the camera.
        double offset = 0;
        double weight = 0;
    };

    bool is_in(int x, int y) const { return x >= 0 && y >= 0 && x < depth_.width && y < depth_.height; }
    double inverse(int x, int y) const { return is_in(x, y) && depth_.at(x, y) > 0 ? 1 / double{depth_.at(x, y)} : 0; }

    const Plane& plane_at(int x, int y)
    {
        const auto found = planes_.find({x, y});
        return found != planes_.end() ? found->second : planes_[{x, y}] = fitted(x, y);
    }

    Plane fitted(int x, int y) const
    {
        const bool is_hole = inverse(x, y) == 0;
        double measured = inverse(x, y);
        if (is_hole)
        {
            std::vector<double> around;
            for (int v = -1; v <= 1; ++v)
                for (int u = -1; u <= 1; ++u)
                    if (inverse(x + u, y + v) > 0)
                        around.push_back(inverse(x + u, y + v));
            if (around.size() < 4)
                return {};
            std::ranges::sort(around);
            measured = around[around.size() / 2];
        }
        const auto tolerance = [](double inverse) { return 0.015 * inverse + 0.006; };
        // 1/z = a + b u + c v.
        std::array<double, 9> normal{};
        std::array<double, 3> fit{};
        int count = 0;
        for (int v = -2; v <= 2; ++v)
            for (int u = -2; u <= 2; ++u)
                if (const double there = inverse(x + u, y + v);
                    there > 0 && std::abs(there - measured) <= tolerance(measured) + 2 * measured *
                                                                                         std::max(std::abs(u), std::abs(v)) /
                                                                                         camera_.intrinsics.fx)
                {
                    const std::array<double, 3> row{1, double(u), double(v)};
                    for (std::size_t i = 0; i < 3; ++i)
                    {
                        fit[i] += row[i] * there;
                        for (std::size_t j = 0; j < 3; ++j)
                            normal[3 * i + j] += row[i] * row[j];
                    }
                    ++count;
                }
        if (count < 6)
            return {};
        numerics::solve_symmetric(normal, fit);
        const double here = fit[0], b = fit[1], c = fit[2];
        int continuing = 0, close = 0, across = 0, apart = 0;
        const auto is_on = [&](int u, int v, double share)
        {
            const double there = inverse(x + u, y + v);
            return there > 0 && std::abs(there - here - b * u - c * v) <= share * tolerance(here);
        };
        for (int v = -1; v <= 1; ++v)
            for (int u = -1; u <= 1; ++u)
            {
                if (!is_in(x + u, y + v))
                    return {};
                if (u == 0 && v == 0)
                    continue;
                if (inverse(x + u, y + v) > 0)
                {
                    (is_on(u, v, 1) ? continuing : apart) += 1;
                    close += is_on(u, v, 0.5);
                }
                else
                    across += is_on(2 * u, 2 * v, 0.5);
            }
        double trust = 1;
        if (is_hole || continuing < 6)
            trust = apart > 0 || close + across < 5 || close < 3 ? 0 : close * close / 256.0;
        if (trust == 0)
            return {};
        // Three points of the plane around the pixel's own.
        const auto point = [&](double u, double v)
        { return camera_.world_from_camera.translation + camera_.ray(x + 0.5 + u, y + 0.5 + v) * (1 / (here + b * u + c * v)); };
        const Vec3d own = point(0, 0);
        Plane plane;
        plane.normal = normalized(cross(point(1e-3, 0) - own, point(0, 1e-3) - own));
        const Vec3d toward = normalized(camera_.world_from_camera.translation - own);
        if (dot(plane.normal, toward) < 0)
            plane.normal = -plane.normal;
        const double cosine = dot(plane.normal, toward);
        plane.offset = dot(plane.normal, own);
        plane.weight = cosine >= 0.2 ? trust * cosine * measured * measured : 0;
        return plane;
    }

    Camera camera_;
    RasterF depth_;
    std::map<std::pair<int, int>, Plane> planes_;
};

}  // namespace

TEST_CASE("a slow and plain integration finds the same distances")
{
    const auto seen = views();
    fuse::Volume volume = opened(seen);
    fuse::integrate(seen, truncation_m, testing::TestRun(2), volume);
    std::vector<SlowView> slow;
    for (const double angle : {0.0, 0.3, 1.1, 2.0, 3.3, 4.4})
        slow.emplace_back(recorded(angle), 1.6);
    std::size_t measured = 0;
    std::size_t differing = 0;
    for (std::size_t i = 0; i < volume.places().size(); ++i)
        for (std::size_t v = 0; v < fuse::block_size; ++v)
        {
            const fuse::Voxel& fast = volume.block(i)[v];
            SlowVoxel plain;
            for (SlowView& view : slow)
                view.add(voxel_position(volume.places()[i], v), plain);
            measured += plain.weight > 0 ? 1 : 0;
            const bool same = (plain.weight > 0) == (fast.weight > 0) &&
                              (plain.weight == 0 || (std::abs(plain.sum / plain.weight - double{fast.distance()}) < 2e-5 &&
                                                     double{fast.weight} == Approx(plain.weight).epsilon(1e-3)));
            differing += same ? 0 : 1;
        }
    CHECK(measured > 100'000);
    // Rounding decides a few measurements.
    CHECK(differing < measured / 1000);
}

TEST_CASE("any number of threads, and frames in any portions, give the same bytes")
{
    const auto seen = views();
    fuse::Volume together = opened(seen);
    fuse::integrate(seen, truncation_m, testing::TestRun(1), together);
    fuse::Volume parted = opened(seen);
    for (const auto& portion : {std::span(seen).first(2), std::span(seen).subspan(2)})
        fuse::integrate(portion, truncation_m, testing::TestRun(5), parted);
    REQUIRE(parted.places() == together.places());
    std::size_t differing = 0;
    for (std::size_t i = 0; i < parted.places().size(); ++i)
        differing += std::memcmp(&parted.block(i), &together.block(i), sizeof(fuse::Block)) != 0 ? 1 : 0;
    CHECK(differing == 0);
}

TEST_CASE("the blocks within reach of every measured point are opened, and no others")
{
    const auto seen = views();
    const fuse::OpenedBlocks rule{voxel_m, truncation_m, 100'000};
    const std::vector<fuse::BlockPlace> places = rule.near(seen[0]);
    REQUIRE(std::ranges::is_sorted(places));
    std::vector<Vec3d> points;
    for (int y = 0; y < seen[0].depth.height; ++y)
        for (int x = 0; x < seen[0].depth.width; ++x)
            if (const double z = double{seen[0].depth.at(x, y)}; z > 0)
                points.push_back(seen[0].camera.world_from_camera.translation + seen[0].camera.ray(x + 0.5, y + 0.5) * z);
    const double side = 8 * voxel_m;
    for (int z = -3; z < 15; ++z)
        for (int y = -3; y < 15; ++y)
            for (int x = -3; x < 20; ++x)
            {
                const auto is_near = [&](Vec3d p)
                {
                    const auto along = [&](double at, int block)
                    { return at + truncation_m >= block * side && at - truncation_m < (block + 1) * side; };
                    return along(p.x, x) && along(p.y, y) && along(p.z, z);
                };
                CHECK(std::ranges::binary_search(places, fuse::BlockPlace{x, y, z}) == std::ranges::any_of(points, is_near));
            }
    CHECK(fuse::OpenedBlocks{voxel_m, truncation_m, places.size()}.near(seen[0]) == places);
    CHECK(fuse::OpenedBlocks{voxel_m, truncation_m, 10}.near(seen[0]).size() == 11);
    // A reach that would open more than any memory holds ends as soon.
    CHECK(fuse::OpenedBlocks{0.001, 10, 1000}.near(seen[0]).size() == 1001);
}
