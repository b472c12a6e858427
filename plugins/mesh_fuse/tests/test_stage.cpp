#include "fusion.h"
#include "seen_colors.h"

#include <fresco/frames.h>
#include <fresco/npy.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

using namespace fresco;
using Catch::Contains;

namespace
{

/// In the middle of a room of 3 m x 2 m x 2.4 m (x, y, z from 0), turned about y.
Camera camera_at(double angle, int width = 160)
{
    Camera camera;
    camera.intrinsics = {width, width * 3 / 4, 0.6 * width, 0.6 * width, 0.5 * width, 0.375 * width};
    camera.world_from_camera.rotation.m = {std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle)};
    camera.world_from_camera.translation = {1.5, 1, 1.2};
    return camera;
}

/// Along the optical axis to the room's walls, floor and ceiling.
RasterF room_depth(const Camera& camera)
{
    const Vec3d size{3, 2, 2.4};
    const Vec3d at = camera.world_from_camera.translation;
    RasterF depth(camera.intrinsics.width, camera.intrinsics.height);
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
        {
            const Vec3d ray = camera.ray(x + 0.5, y + 0.5);
            const auto wall = [](double from, double along, double far) {
                return along > 0 ? (far - from) / along : along < 0 ? -from / along : 1e9;
            };
            depth.at(x, y) =
                static_cast<float>(std::min({wall(at.x, ray.x, size.x), wall(at.y, ray.y, size.y), wall(at.z, ray.z, size.z)}));
        }
    return depth;
}

double distance_to_walls(Vec3f p)
{
    return std::min({std::abs(double{p.x}), std::abs(p.x - 3.0), std::abs(double{p.y}), std::abs(p.y - 2.0),
                     std::abs(double{p.z}), std::abs(p.z - 2.4)});
}

/// Six frames around, with depth in millimeters, written below `folder`.
std::shared_ptr<Frames> room_frames(const std::filesystem::path& folder)
{
    auto frames = std::make_shared<Frames>();
    for (int i = 0; i < 6; ++i)
    {
        Frame frame;
        frame.sequence = "seq-01";
        frame.name = "frame-" + std::to_string(i);
        frame.depth = frame.color = camera_at(i * std::numbers::pi / 3);
        const RasterF depth = room_depth(frame.depth);
        std::vector<std::uint16_t> steps;
        for (const float meters : depth.values)
            steps.push_back(static_cast<std::uint16_t>(std::lround(1000 * meters)));
        frame.depth_picture.path = folder / (frame.name + ".depth.npy");
        write_npy(frame.depth_picture.path, std::vector<std::size_t>{120, 160}, steps);
        frame.color_picture.path = folder / (frame.name + ".color.npy");
        write_npy(frame.color_picture.path, std::vector<std::size_t>{120, 160, 3}, std::vector<std::uint8_t>(120 * 160 * 3, 90));
        frames->frames.push_back(frame);
    }
    return frames;
}

std::shared_ptr<Mesh> fuse(const std::shared_ptr<Frames>& frames, const Value& options, testing::TestRun& run)
{
    const testing::TemporaryFolder folder;
    const auto made = testing::make_from_plugin(FRESCO_PLUGIN_FILE, "mesh.fuse");
    testing::TestFactory factory;
    testing::run_stage(dynamic_cast<Stage&>(*made), options, {{"frames", frames}}, folder.path(), run, factory);
    return Mesh::load({folder.path() / "mesh", folder.path()});
}

}  // namespace

TEST_CASE("a wall straight ahead lies where it was measured, to a fraction of a voxel, and faces the camera")
{
    const Camera camera = camera_at(0);
    RasterF depth(160, 120, 1, 1.3F);
    Fusion fusion({0.02, 0.08});
    CHECK(fusion.bytes() == 0);
    fusion.add(depth, Raster8(160, 120, 3, 200), camera);
    const Mesh mesh = fusion.mesh();
    CHECK(fusion.bytes() > 1'000'000);
    REQUIRE(mesh.triangles.size() > 5000);
    float low_x = 10;
    float high_x = -10;
    for (const Vec3f p : mesh.positions)
    {
        CHECK(std::abs(p.z - 2.5F) < 0.002F);
        low_x = std::min(low_x, p.x);
        high_x = std::max(high_x, p.x);
    }
    // The picture spans 1.3 m / 0.6 about the camera's x: half a pixel more or less would be 7 mm.
    const double half = 1.3 / 1.2;
    CHECK(low_x == Approx(1.5 - half).margin(0.03));
    CHECK(high_x == Approx(1.5 + half).margin(0.03));
    CHECK((low_x + high_x) / 2 == Approx(1.5).margin(0.012));
    for (const Vec3d normal : {Vec3d{0, 0, -1}})
    {
        double toward = 0;
        for (const Vec3f n : face_normals(mesh))
            toward += dot(vec_cast<double>(n), normal);
        CHECK(toward / static_cast<double>(mesh.triangles.size()) > 0.99);
    }
    CHECK(mesh.colors.size() == mesh.positions.size());
    for (const Rgb8 color : mesh.colors)
        CHECK(std::abs(color[0] - 200) <= 1);
}

TEST_CASE("a slanted wall lies where it was measured: pixels are looked at in their middles")
{
    // z = 2.5 + 0.8 (x - 1.5): half a pixel, 7 mm at this distance, would shift it by 5 mm.
    const Camera camera = camera_at(0);
    RasterF depth(160, 120);
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x)
            depth.at(x, y) = static_cast<float>(1.3 / (1 - 0.8 * camera.ray(x + 0.5, y + 0.5).x));
    Fusion fusion({0.02, 0.08});
    fusion.add(depth, Raster8(160, 120, 3), camera);
    double sum = 0;
    const Mesh mesh = fusion.mesh();
    for (const Vec3f p : mesh.positions)
        sum += double{p.z} - 2.5 - 0.8 * (double{p.x} - 1.5);
    REQUIRE(mesh.positions.size() > 5000);
    CHECK(std::abs(sum / static_cast<double>(mesh.positions.size())) < 0.001);
}

TEST_CASE("what a picture will take is known before it is added")
{
    Fusion fusion({0.02, 0.05});
    for (const double angle : {0.0, 0.2})
        for (const int width : {160, 640})
        {
            const Camera camera = camera_at(angle, width);
            const RasterF depth = room_depth(camera);
            Fusion ahead({0.02, 0.05});
            ahead.add(depth, Raster8(width, width * 3 / 4, 3), camera);
            CHECK(Fusion({0.02, 0.05}).fits(depth, camera, ahead.bytes()));
            CHECK_FALSE(Fusion({0.02, 0.05}).fits(depth, camera, ahead.bytes() - 1));
            // Beside what is there already.
            fusion.add(depth, Raster8(width, width * 3 / 4, 3), camera);
            CHECK(fusion.fits(depth, camera, fusion.bytes()));
        }
}

TEST_CASE("a room is fused from what was recorded in its middle")
{
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    const auto mesh = fuse(room_frames(folder.path()), Value::Map{{"voxel_m", 0.03}}, run);
    CHECK(run.reported.at("frames").as_int() == 6);
    std::size_t close = 0;
    for (const Vec3f p : mesh->positions)
        close += distance_to_walls(p) < 0.01;
    CHECK(static_cast<double>(close) > 0.95 * static_cast<double>(mesh->positions.size()));
    const auto normals = face_normals(*mesh);
    double area = 0;
    double inwards = 0;
    for (std::size_t face = 0; face < mesh->triangles.size(); ++face)
    {
        const Triangle& t = mesh->triangles[face];
        const Vec3d a = vec_cast<double>(mesh->positions[t[0]]);
        const double size =
            length(cross(vec_cast<double>(mesh->positions[t[1]]) - a, vec_cast<double>(mesh->positions[t[2]]) - a)) / 2;
        area += size;
        if (dot(vec_cast<double>(normals[face]), Vec3d{1.5, 1, 1.2} - a) > 0)
            inwards += size;
    }
    // Four walls without their upper and lower parts, and the floor and ceiling around: less than the whole 36 m2.
    CHECK(area > 18);
    CHECK(area < 36);
    CHECK(inwards > 0.99 * area);
    testing::TestRun again;
    const auto same = fuse(room_frames(folder.path()), Value::Map{{"voxel_m", 0.03}}, again);
    CHECK(same->positions == mesh->positions);
    CHECK(same->triangles == mesh->triangles);
}

TEST_CASE("colors are taken from where the color camera is")
{
    const Camera depth_camera = camera_at(0, 16);
    Camera color_camera = camera_at(0, 32);
    // A baseline of 0.5 m at 1 m and focal lengths 9.6 and 19.2: 9.6 color pixels to the left.
    color_camera.world_from_camera.translation.x += 0.5;
    Raster8 picture(32, 24, 3);
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 32; ++x)
            picture.at(x, y, 0) = static_cast<std::uint8_t>(x);
    RasterF depth(16, 12, 1, 1);
    depth.at(3, 3) = 0;
    const Raster8 seen = seen_colors(depth, depth_camera, picture, color_camera);
    CHECK(seen.at(10, 5) == std::floor(21 - 9.6));
    CHECK(seen.at(12, 5) == std::floor(25 - 9.6));
    CHECK(seen.at(0, 5) == 0);  // beside the picture: its border
    CHECK(seen.at(3, 3) == 0);
}

TEST_CASE("what cannot be fused is refused with a way out")
{
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    auto frames = room_frames(folder.path());
    CHECK_THROWS_WITH(fuse(frames, Value::Map{{"max_memory_gb", 0.01}}, run), Contains("raise max_memory_gb or voxel_m"));
    CHECK_THROWS_WITH(fuse(frames, Value::Map{{"trunc_m", 0.01}}, run), Contains("less than voxel_m"));
    CHECK_THROWS_WITH(fuse(frames, Value::Map{{"max_depth_m", 0.2}}, run), Contains("show no surface"));
    frames->frames[0].depth_picture = {};
    fuse(frames, Value::Map{{"voxel_m", 0.1}}, run);
    CHECK(run.messages.back() == "warning: 1 of 6 frames have no depth picture and are left out");
    for (Frame& frame : frames->frames)
        frame.depth_picture = {};
    CHECK_THROWS_WITH(fuse(frames, Value::Map{}, run), Contains("has a depth picture: use a scan"));
    run.cancel_after(1);
    CHECK_THROWS_AS(fuse(frames, Value::Map{}, run), Canceled);
}
