#include "catch.h"
#include "free_space.h"
#include "rooms.h"
#include "view_plan.h"

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/raycast/ray_finder.h>
#include <fresco/stage.h>
#include <fresco/testing.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <array>
#include <iostream>

namespace fs = std::filesystem;
using namespace fresco;
using namespace rooms;

namespace
{

Frames one_frame()
{
    Frames frames;
    frames.frames.push_back(frame_before_cupboard());
    return frames;
}

Frames planned(const Mesh& mesh, const Frames& frames, Value::Map options, testing::TestRun& run)
{
    const testing::TemporaryFolder out;
    Value given = Value::Map{{"cells_px", 128}, {"voxel_m", 0.4}, {"clearance_m", 0.2}, {"gap_px", 0}, {"target_coverage", 1}};
    for (auto& [name, value] : options)
        given.set(name, value);
    testing::run_stage(FRESCO_PLUGIN_FILE, "frames.virtual", given,
                       {{"mesh", std::make_shared<Mesh>(mesh)}, {"frames", std::make_shared<Frames>(frames)}}, out.path(), run);
    return *Frames::load({out.path() / "frames", {}});
}

double figure(const testing::TestRun& run, const char* name)
{
    return run.reported.at(name).as_double();
}

/// 1 for the texels that a view's pixels touch, as texture.optimize looks them up.
void touch(const UvMap& map, int size, std::vector<std::uint8_t>& touched)
{
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
    {
        if (map.valid.values[i] == 0)
            continue;
        const auto first = [&](double share) { return static_cast<int>(std::floor(share * size - 0.5)); };
        const int x = first(double{map.uv.values[2 * i]});
        const int y = first(1 - double{map.uv.values[2 * i + 1]});
        for (const int row : {y, y + 1})
            for (const int column : {x, x + 1})
                touched[static_cast<std::size_t>(std::clamp(row, 0, size - 1) * size + std::clamp(column, 0, size - 1))] = 1;
    }
}

}  // namespace

TEST_CASE("virtual frames follow the recorded ones and see the surface behind the cupboard", "[frames.virtual]")
{
    const Mesh mesh = room_with_cupboard();
    testing::TestRun run;
    const auto all = planned(mesh, one_frame(), {}, run);
    REQUIRE(all.frames.size() > 6);
    CHECK(all.frames[0].name == "frame-000000");
    for (std::size_t i = 1; i < all.frames.size(); ++i)
    {
        const Frame& frame = all.frames[i];
        CHECK(frame.sequence == "virtual");
        CHECK(frame.number == static_cast<long>(i) - 1);
        CHECK(frame.color_picture.empty());
        CHECK(frame.depth_picture.empty());
        CHECK(frame.color == frame.depth);
        CHECK(frame.color.intrinsics == all.frames[0].color.intrinsics);
        CHECK_THROWS_WITH(load_color(frame, nullptr),
                          Catch::Contains("virtual/view-0000") && Catch::Contains("no color picture"));
    }
    CHECK(all.frames[1].name == "view-000000");
    CHECK(figure(run, "recorded_frames") == 1);
    CHECK(figure(run, "virtual_frames") == static_cast<double>(all.frames.size() - 1));
    CHECK(figure(run, "coverage") == 1);
    CHECK(figure(run, "coverage_recorded") > 0.1);
    CHECK(figure(run, "coverage_recorded") < 0.3);
    // All but the cupboard's floor, the room's below it and the wall behind the wall.
    CHECK(figure(run, "reachable_share") == Approx(1 - 8.7 / 73.82).margin(0.01));
    REQUIRE(run.messages.size() == 1);
    CHECK_THAT(run.messages.front(), Catch::Contains("1 recorded frames paint") && Catch::Contains("100.00 %"));
}

TEST_CASE("a share, a number and the kind of frames are as asked for", "[frames.virtual]")
{
    const Mesh mesh = room_with_cupboard();
    testing::TestRun run;
    const std::size_t all = planned(mesh, one_frame(), {{"only_virtual", true}}, run).frames.size();
    CHECK(figure(run, "virtual_frames") == static_cast<double>(all));
    const auto half = planned(mesh, one_frame(), {{"only_virtual", true}, {"target_coverage", 0.5}}, run);
    CHECK(half.frames.size() < all);
    const double recorded = figure(run, "coverage_recorded");
    CHECK(figure(run, "coverage") >= recorded + 0.5 * (1 - recorded));
    CHECK(planned(mesh, one_frame(), {{"max_frames", 2}}, run).frames.size() == 3);
    CHECK(figure(run, "coverage") < 1);
    // Paint spreads by four texels of 256, two cells of 128.
    CHECK(planned(mesh, one_frame(), {{"gap_px", 4}, {"only_virtual", true}}, run).frames.size() < all);
    CHECK(figure(run, "coverage_recorded") > recorded);

    // Virtual views of all the room recorded it: nothing is left to plan.
    Frames recording;
    for (Frame frame : planned(mesh, one_frame(), {}, run).frames)
    {
        frame.sequence = "seq-01";
        recording.frames.push_back(frame);
    }
    testing::TestRun again;
    CHECK(planned(mesh, recording, {}, again).frames.size() == recording.frames.size());
    CHECK(figure(again, "coverage_recorded") == 1);
    CHECK(planned(mesh, recording, {{"only_virtual", true}}, again).frames.empty());
    CHECK_THAT(again.messages.back(), Catch::Contains("warning: ") && Catch::Contains("there are no virtual frames"));
}

TEST_CASE("what cannot be planned is refused by name", "[frames.virtual]")
{
    const Mesh mesh = room_with_cupboard();
    testing::TestRun run;
    const auto refusal = [&](const Mesh& room, const Frames& frames, Value::Map options, const char* text)
    { CHECK_THROWS_WITH(planned(room, frames, std::move(options), run), Catch::Contains(text)); };
    refusal(mesh, Frames(), {}, "no frames");
    Mesh bare = mesh;
    bare.texcoords.clear();
    refusal(bare, one_frame(), {}, "atlas.*");
    refusal(mesh, one_frame(), {{"voxel_m", 20}}, "option \"voxel_m\" (20 m) is larger than the room");
    refusal(mesh, one_frame(), {{"clearance_m", 3}}, "option \"clearance_m\" (3 m) is larger than the room");
    refusal(mesh, one_frame(), {{"clearance_m", 1.3}}, "1.3 m (clearance_m) from all surfaces");
    auto twice = one_frame();
    twice.frames.push_back(twice.frames[0]);
    twice.frames[1].sequence = "virtual";
    refusal(mesh, twice, {}, "already has a virtual frame (virtual/frame-000000)");
    // Inside the cupboard, where all faces show their backs.
    auto inside = one_frame();
    inside.frames[0].color.world_from_camera.translation = {2.95, 1.5, 0.9};
    refusal(mesh, inside, {{"clearance_m", 0.06}, {"voxel_m", 0.1}}, "no free space");
    // In the room, but looking at nothing that faces it.
    Mesh away = mesh;
    for (auto& triangle : away.triangles)
        std::swap(triangle[1], triangle[2]);
    refusal(away, one_frame(), {}, "no free space");
    auto blind = one_frame();
    blind.frames[0].color.world_from_camera = {{{0, 0, 1, -1, 0, 0, 0, -1, 0}}, {3.97, 1.5, 1.4}};
    refusal(mesh, blind, {}, "none of the 1 frames sees the front of the mesh");
    testing::TestRun stopped;
    stopped.cancel_after(4);
    CHECK_THROWS_AS(planned(mesh, one_frame(), {}, stopped), Canceled);
}

TEST_CASE("every texel of the generated room that free space reaches is painted by a third of its frames and virtual ones",
          "[frames.virtual]")
{
    const auto plugins = fs::path(FRESCO_PLUGIN_FILE).parent_path();
    for (const char* needed : {"image_opencv.so", "scan_synthetic_room.so", "atlas_project.so"})
        if (!fs::exists(plugins / needed))
        {
            std::cout << "SKIPPED frames.virtual on the generated room: " << needed << " is not built" << std::endl;
            return;
        }
    const std::shared_ptr<Component> images = testing::make_from_plugin<Component>(plugins / "image_opencv.so", "image.opencv");
    const testing::TemporaryFolder out;
    testing::TestRun run;
    testing::run_stage(plugins / "scan_synthetic_room.so", "scan.synthetic_room",
                       Value::Map{{"frames_count", 24},
                                  {"color_width_px", 160},
                                  {"color_height_px", 120},
                                  {"depth_width_px", 160},
                                  {"depth_height_px", 120},
                                  {"edge_m", 0.1}},
                       {}, out.path(), run, {{"images", images}});
    Frames third = *Frames::load({out.path() / "frames", {}});
    third.frames.resize(8);
    constexpr int size = 256;
    testing::run_stage(plugins / "atlas_project.so", "atlas.project", Value::Map{{"size_px", size}},
                       {{"mesh", Mesh::load({out.path() / "mesh", {}})}}, out.path() / "atlas", run);
    const Mesh mesh = *Mesh::load({out.path() / "atlas/atlas", {}});
    constexpr double voxel_m = 0.25;
    constexpr double clearance_m = 0.25;
    const auto all =
        planned(mesh, third, {{"cells_px", size}, {"voxel_m", voxel_m}, {"clearance_m", clearance_m}, {"gap_px", 4}}, run);

    // What the optimizer renders at 240 px, and what its coarse layers reach from there.
    std::vector<std::uint8_t> touched(size * size);
    std::size_t recorded = 0;
    UvMapper mapper(mesh, std::make_unique<raycast::RayFinder>(mesh));
    const std::array heights{240};
    for (std::size_t i = 0; i < all.frames.size(); ++i)
    {
        touch(mapper.make(all.frames[i].color, heights, run).front().map, size, touched);
        if (i + 1 == third.frames.size())
            recorded = static_cast<std::size_t>(std::ranges::count(touched, 1));
    }
    const auto points = virtual_views::surface_points(mesh, size, run);
    std::vector<std::int64_t> chart_at(size * size, -1);
    for (const auto& point : points)
        chart_at[point.cell] = point.chart;
    const auto painted = [&](const virtual_views::SurfacePoint& point)
    {
        const int x = static_cast<int>(point.cell) % size;
        const int y = static_cast<int>(point.cell) / size;
        for (int row = std::max(0, y - 4); row <= std::min(size - 1, y + 4); ++row)
            for (int column = std::max(0, x - 4); column <= std::min(size - 1, x + 4); ++column)
            {
                const auto near = static_cast<std::size_t>(row * size + column);
                if (touched[near] != 0 && chart_at[near] == point.chart)
                    return true;
            }
        return false;
    };

    // Free space by every voxel, for every texel.
    std::vector<Vec3d> eyes;
    for (const Frame& frame : third.frames)
        eyes.push_back(frame.color.world_from_camera.translation);
    const raycast::Scene scene(mesh);
    const auto places = virtual_views::free_space(
        scene, virtual_views::VoxelGrid(mesh, eyes, {.voxel_m = voxel_m, .clearance_m = clearance_m}), eyes, clearance_m, run);
    std::vector<std::uint8_t> reached(points.size());
    parallel_for(points.size(), 256, 2,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                         for (const Vec3d place : places)
                         {
                             const std::array toward{vec_cast<double>(points[i].position) - place};
                             std::array<raycast::Hit, 1> hit;
                             if (dot(toward[0], vec_cast<double>(points[i].normal)) >= 0)
                                 continue;
                             scene.cast(place, toward, hit);
                             if (hit[0].triangle == points[i].face)
                             {
                                 reached[i] = 1;
                                 break;
                             }
                         }
                 });
    std::size_t reachable = 0;
    std::size_t missed = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (reached[i] != 0)
        {
            ++reachable;
            missed += painted(points[i]) ? 0 : 1;
        }
    CAPTURE(points.size(), reachable, recorded, all.frames.size(), places.size());
    CHECK(reachable > 9 * points.size() / 10);
    CHECK(recorded < 9 * reachable / 10);
    CHECK(missed == 0);
}
