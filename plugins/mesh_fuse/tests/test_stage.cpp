#include "catch.h"
#include "room.h"

#include <fresco/frames.h>
#include <fresco/geometry/topology.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/testing.h>

#include <cmath>
#include <functional>
#include <numbers>

using namespace fresco;
using Catch::Contains;

namespace
{

/// A depth picture in tenths of a millimeter and a gray picture of one camera, written below `folder`.
Frame written(const std::filesystem::path& folder, const std::string& name, const Camera& camera, const RasterF& depth)
{
    Frame frame = testing::frame(name, camera);
    frame.depth_unit_m = 0.0001;
    testing::set_depth_picture(frame, folder, depth);
    testing::set_color_picture(frame, folder, Raster8(depth.width, depth.height, 3, 90));
    return frame;
}

/// Six frames around.
std::shared_ptr<Frames> room_frames(const std::filesystem::path& folder)
{
    auto frames = std::make_shared<Frames>();
    for (int i = 0; i < 6; ++i)
    {
        const Camera camera = test_room::camera_at(i * std::numbers::pi / 3);
        frames->frames.push_back(written(folder, "frame-" + std::to_string(i), camera, test_room::depth_of(camera)));
    }
    return frames;
}

/// One frame, straight ahead, of what `depth` says about each pixel's ray.
std::shared_ptr<Frames> one_frame(const std::filesystem::path& folder, const std::function<double(int, int, Vec3d)>& depth)
{
    const Camera camera = test_room::camera_at(0);
    RasterF picture(camera.intrinsics.width, camera.intrinsics.height);
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            picture.at(x, y) = static_cast<float>(depth(x, y, camera.ray(x + 0.5, y + 0.5)));
    auto frames = std::make_shared<Frames>();
    frames->frames.push_back(written(folder, "frame-0", camera, picture));
    return frames;
}

std::shared_ptr<Mesh> fuse_frames(const std::shared_ptr<Frames>& frames, const Value& options, testing::TestRun& run,
                                  const std::shared_ptr<Mesh>& given = nullptr)
{
    const testing::TemporaryFolder folder;
    testing::Inputs inputs{{"frames", frames}};
    if (given)
        inputs["mesh"] = given;
    testing::run_stage(FRESCO_PLUGIN_FILE, "mesh.fuse", options, inputs, folder.path(), run);
    return Mesh::load({folder.path() / "mesh", folder.path()});
}

double inward_share(const Mesh& mesh)
{
    double area = 0;
    double inward = 0;
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        const Vec3d normal = geometry::area_vector(mesh, face);
        area += length(normal);
        inward +=
            dot(normal, test_room::middle - vec_cast<double>(mesh.positions[mesh.triangles[face][0]])) > 0 ? length(normal) : 0;
    }
    return inward / area;
}

}  // namespace

TEST_CASE("a slanted wall lies where it was measured: pixels are looked at in their middles")
{
    // z = 2.5 + 0.8 (x - 1.5): half a pixel, 7 mm at this distance, would shift it by 5 mm.
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    const auto frames = one_frame(folder.path(), [](int, int, Vec3d ray) { return 1.3 / (1 - 0.8 * ray.x); });
    const auto mesh = fuse_frames(frames, Value::Map{{"voxel_m", 0.02}}, run);
    REQUIRE(mesh->positions.size() > 5000);
    for (const Vec3f p : mesh->positions)
        CHECK(std::abs(double{p.z} - 2.5 - 0.8 * (double{p.x} - 1.5)) < 0.001);
}

TEST_CASE("a room is fused from what was recorded in its middle, alike for any number of threads")
{
    const testing::TemporaryFolder folder;
    const auto frames = room_frames(folder.path());
    testing::TestRun run;
    const auto mesh = fuse_frames(frames, Value::Map{{"voxel_m", 0.03}}, run);
    CHECK(run.reported.at("fused").as_bool());
    CHECK(run.reported.at("frames").as_int() == 6);
    CHECK(run.reported.at("faces").as_int() == static_cast<std::int64_t>(mesh->triangles.size()));
    std::size_t close = 0;
    for (const Vec3f p : mesh->positions)
        close += test_room::distance_to_walls(p) < 0.003 ? 1 : 0;
    CHECK(static_cast<double>(close) > 0.95 * static_cast<double>(mesh->positions.size()));
    // Four walls without their upper and lower parts, and the floor and ceiling around: less than the whole 36 m2.
    const geometry::SurfaceCounts counts = geometry::count_surface(*mesh);
    CHECK(counts.area_m2 > 18);
    CHECK(counts.area_m2 < 36);
    CHECK(counts.complex_edges == 0);
    CHECK(inward_share(*mesh) > 0.999);
    for (const int threads : {1, 3})
    {
        testing::TestRun again(threads);
        const auto same = fuse_frames(frames, Value::Map{{"voxel_m", 0.03}}, again);
        CHECK(same->positions == mesh->positions);
        CHECK(same->triangles == mesh->triangles);
        CHECK(same->colors == mesh->colors);
    }
}

TEST_CASE("specks before a wall go, pieces of a size stay")
{
    // A speck of 7 x 7 pixels and a sheet of 30 x 30, far before the wall.
    const testing::TemporaryFolder folder;
    const auto frames = one_frame(folder.path(),
                                  [](int x, int y, Vec3d)
                                  {
                                      const bool speck = std::abs(x - 40) <= 3 && std::abs(y - 40) <= 3;
                                      const bool sheet = std::abs(x - 110) <= 15 && std::abs(y - 60) <= 15;
                                      return speck || sheet ? 0.7 : 1.3;
                                  });
    testing::TestRun run;
    const Value options = Value::Map{{"voxel_m", 0.01}};
    const auto mesh = fuse_frames(frames, options, run);
    CHECK(run.reported.at("components_removed").as_int() == 1);
    CHECK(geometry::count_surface(*mesh).components == 2);
    Value all = options;
    all.set("min_component_m2", 0);
    CHECK(geometry::count_surface(*fuse_frames(frames, all, run)).components == 3);
    all.set("min_component_m2", 0.2);
    CHECK(geometry::count_surface(*fuse_frames(frames, all, run)).components == 1);
}

TEST_CASE("a mesh that is given is passed on as it is")
{
    const testing::TemporaryFolder folder;
    auto frames = room_frames(folder.path());
    for (Frame& frame : frames->frames)
        frame.depth_picture = {};
    auto given = std::make_shared<Mesh>();
    given->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    given->colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
    given->triangles = {{0, 1, 2}};
    given->texcoords = {{0, 0}, {1, 0}, {0, 1}};
    testing::TestRun run;
    const auto passed = fuse_frames(frames, Value::Map{}, run, given);
    CHECK(to_json(run.reported) == R"({"fused":false})");
    CHECK(passed->positions == given->positions);
    CHECK(passed->colors == given->colors);
    CHECK(passed->triangles == given->triangles);
    CHECK(passed->texcoords == given->texcoords);
}

TEST_CASE("views that contradict each other are told")
{
    const testing::TemporaryFolder folder;
    auto frames = room_frames(folder.path());
    testing::TestRun right;
    fuse_frames(frames, Value::Map{{"voxel_m", 0.03}}, right);
    CHECK(right.reported.at("contradicted_share").as_double() < 0.05);
    CHECK(right.messages.empty());
    // Three frames see a wall at 0.7 times the distance at which one sees it.
    frames->frames.assign(4, frames->frames[0]);
    for (std::size_t i = 1; i < 4; ++i)
        frames->frames[i].depth_unit_m *= 0.7;
    testing::TestRun wrong;
    fuse_frames(frames, Value::Map{{"voxel_m", 0.03}}, wrong);
    CAPTURE(wrong.reported.at("contradicted_share").as_double());
    REQUIRE(wrong.messages.size() == 1);
    CHECK_THAT(wrong.messages[0], Contains("contradict each other"));
}

TEST_CASE("what cannot be fused is refused with a way out")
{
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    auto frames = room_frames(folder.path());
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"max_memory_gb", 0.01}}, run),
                      Contains("of 6 frames, the volume needs more than max_memory_gb (0.01)") &&
                          Contains("raise max_memory_gb or voxel_m"));
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"trunc_m", 0.005}}, run), Contains("less than voxel_m"));
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"max_depth_m", 0.2}}, run), Contains("show no surface"));
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"voxel_m", 0.1}, {"min_component_m2", 100}}, run),
                      Contains("at least min_component_m2"));
    frames->frames[0].depth_picture = {};
    fuse_frames(frames, Value::Map{{"voxel_m", 0.1}}, run);
    CHECK(run.messages.back() == "warning: 1 of 6 frames have no depth picture and are left out");
    for (Frame& frame : frames->frames)
        frame.depth_picture = {};
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{}, run),
                      Contains("has a depth picture: use a scan with depth, or wire a mesh"));
    for (const int checks : {1, 10, 20})
    {
        run.cancel_after(checks);
        CHECK_THROWS_AS(fuse_frames(room_frames(folder.path()), Value::Map{{"voxel_m", 0.1}}, run), Canceled);
    }
}
