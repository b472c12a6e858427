#include "catch.h"
#include "plugin_under_test.h"
#include "rooms.h"
#include "view_plan.h"

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/testing.h>
#include <fresco/uv_mapping/uv_mapper.h>

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

constexpr virtual_views::VirtualFrames coarse{
    .target_coverage = 1, .voxel_m = 0.4, .clearance_m = 0.2, .cells_px = 128, .gap_px = 0};

template <class Change>
virtual_views::VirtualFrames with(const Change& change)
{
    auto settings = coarse;
    change(settings);
    return settings;
}

Frames planned(const Mesh& mesh, const Frames& frames, testing::TestRun& run,
               const virtual_views::VirtualFrames& settings = coarse)
{
    return with_virtual_frames(mesh, frames, settings, run);
}

double figure(const testing::TestRun& run, const char* name)
{
    return run.reported.at(name).as_double();
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "virtual frames follow the recorded ones and see the surface behind the cupboard",
                 "[frames.virtual]")
{
    const Mesh mesh = room_with_cupboard();
    const auto all = planned(mesh, one_frame(), run);
    REQUIRE(all.frames.size() > 6);
    CHECK(all.frames[0].name == "frame-000000");
    for (std::size_t i = 1; i < all.frames.size(); ++i)
    {
        const Frame& frame = all.frames[i];
        CHECK(frame.sequence == "virtual");
        CHECK(frame.number == static_cast<long>(i) - 1);
        CHECK(frame.color == frame.depth);
        CHECK(frame.color.intrinsics == all.frames[0].color.intrinsics);
        CHECK_THROWS_WITH(load_color(frame, nullptr),
                          Catch::Contains("virtual/view-0000") && Catch::Contains("no color picture"));
    }
    CHECK(all.frames[1].name == "view-000000");
    CHECK(figure(run, "coverage") == 1);
    CHECK(figure(run, "coverage_recorded") > 0.1);
    CHECK(figure(run, "coverage_recorded") < 0.3);
    // All but the cupboard's floor, the room's below it and the wall behind the wall.
    CHECK(figure(run, "reachable_share") == Approx(1 - 8.7 / 73.82).margin(0.01));
    CHECK_THAT(run.messages.at(0), Catch::Contains("1 recorded frames paint") && Catch::Contains("100.00 %"));
}

TEST_CASE_METHOD(testing::StageTest, "cameras turned every way before a mesh that does not show which way is up are named",
                 "[frames.virtual]")
{
    Frames frames = one_frame();
    frames.frames.push_back(frames.frames.front());
    frames.frames[1].name = "frame-000001";
    // The second is held upside down.
    for (const std::size_t i : {0, 1, 3, 4, 6, 7})
        frames.frames[1].color.world_from_camera.rotation.m[i] *= -1;
    const testing::TemporaryFolder out;
    testing::run_stage(FRESCO_PLUGIN_FILE, "frames.virtual", Value::Map{{"max_frames", 1}},
                       {{"mesh", std::make_shared<Mesh>(room_with_cupboard())}, {"frames", std::make_shared<Frames>(frames)}},
                       out.path(), run);
    CHECK(Frames::load({out.path() / "frames", {}})->frames.size() == 3);
    REQUIRE_FALSE(run.messages.empty());
    CHECK_THAT(run.messages.front(), Catch::Contains("warning: neither the cameras nor the mesh clearly shows which way is up"));
}

TEST_CASE_METHOD(testing::StageTest, "a share and a number of frames are as asked for", "[frames.virtual]")
{
    const Mesh mesh = room_with_cupboard();
    const std::size_t all = planned(mesh, one_frame(), run).frames.size();
    CHECK(figure(run, "virtual_frames") == static_cast<double>(all - 1));
    const auto half = planned(mesh, one_frame(), run, with([](auto& s) { s.target_coverage = 0.5; }));
    CHECK(half.frames.size() < all);
    const double recorded = figure(run, "coverage_recorded");
    CHECK(figure(run, "coverage") >= recorded + 0.5 * (1 - recorded));
    CHECK(planned(mesh, one_frame(), run, with([](auto& s) { s.max_frames = 2; })).frames.size() == 3);
    CHECK(figure(run, "coverage") < 1);
    // Paint spreads by four texels of 256, two cells of 128.
    CHECK(planned(mesh, one_frame(), run, with([](auto& s) { s.gap_px = 4; })).frames.size() < all);
    CHECK(figure(run, "coverage_recorded") > recorded);

    // Virtual views of all the room recorded it: nothing is left to plan.
    Frames recording;
    for (Frame frame : planned(mesh, one_frame(), run).frames)
    {
        frame.sequence = "seq-01";
        recording.frames.push_back(frame);
    }
    testing::TestRun again;
    CHECK(planned(mesh, recording, again).frames.size() == recording.frames.size());
    CHECK(figure(again, "coverage_recorded") == 1);
}

TEST_CASE_METHOD(testing::StageTest, "what cannot be planned is refused by name", "[frames.virtual]")
{
    const Mesh mesh = room_with_cupboard();
    const auto refusal =
        [&](const Mesh& room, const Frames& frames, const virtual_views::VirtualFrames& settings, const char* text)
    { CHECK_THROWS_WITH(planned(room, frames, run, settings), Catch::Contains(text)); };
    const auto sizes = [](double voxel_m, double clearance_m)
    { return with([&](auto& s) { std::tie(s.voxel_m, s.clearance_m) = std::pair(voxel_m, clearance_m); }); };
    refusal(mesh, Frames(), coarse, "no frames");
    Mesh bare = mesh;
    bare.texcoords.clear();
    refusal(bare, one_frame(), coarse, "atlas.*");
    refusal(mesh, one_frame(), sizes(0.001, 0.1), "voxels of 0.001 m");
    refusal(mesh, one_frame(), sizes(20, 0.2), "expected at least 20 m");
    refusal(mesh, one_frame(), sizes(0.4, 3), "expected at least 6 m");
    refusal(mesh, one_frame(), sizes(0.4, 1.3), "1.3 m from all surfaces");
    auto twice = one_frame();
    twice.frames.push_back(twice.frames[0]);
    twice.frames[1].sequence = "virtual";
    refusal(mesh, twice, coarse, "already has a virtual frame (virtual/frame-000000)");
    // Inside the cupboard, where all faces show their backs.
    auto inside = one_frame();
    inside.frames[0].color.world_from_camera.translation = {2.95, 1.5, 0.9};
    refusal(mesh, inside, sizes(0.1, 0.06), "no free space");
    auto blind = one_frame();
    blind.frames[0].color.world_from_camera = {{{0, 0, 1, -1, 0, 0, 0, -1, 0}}, {3.97, 1.5, 1.4}};
    refusal(mesh, blind, coarse, "none of the 1 frames sees the front of the mesh");
    testing::TestRun stopped;
    stopped.cancel_after(4);
    CHECK_THROWS_AS(planned(mesh, one_frame(), stopped), Canceled);
}
