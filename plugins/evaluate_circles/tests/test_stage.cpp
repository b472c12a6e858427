#include "catch.h"
#include "painted_discs.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>

#include <algorithm>

using namespace fresco;

namespace
{
/// A wall at z = 2 m with three discs, seen by cameras of a narrow, high picture from 2 m and from 1 m.
class Recording
{
  public:
    explicit Recording(int height)
    {
        mesh->positions = {{-9, -9, 2}, {9, -9, 2}, {9, 9, 2}, {-9, 9, 2}};
        mesh->triangles = {{0, 2, 1}, {0, 3, 2}};
        const painted_discs::Scene scene{{{{0, 0, 2}, {0, 0, -1}}},
                                         {{0, {0, -0.5, 2}, 0.1}, {0, {0.02, 0, 2}, 0.12}, {0, {0, 0.4, 2}, 0.08}}};
        for (const double z : {0.0, 1.0})
        {
            Frame frame;
            frame.sequence = "s";
            frame.name = z == 0 ? "far" : "near";
            frame.color = frame.depth = painted_discs::camera(100, height, 300);
            frame.color.world_from_camera.translation = {0, 0, z};
            frames->frames.push_back(frame);
            views->names.push_back("s_" + frame.name + ".png");
            write_file(folder.path() / views->names.back(),
                       stored_png::Codec().encode_png(painted_discs::render(scene, frame.color)));
        }
        views->loaded_from = folder.path();
    }

    Files judge(const Value& options, testing::TestRun& run, const std::filesystem::path& out) const
    {
        testing::run_stage(FRESCO_PLUGIN_FILE, "evaluate.circles", options,
                           {{"views", views}, {"frames", frames}, {"mesh", mesh}}, out, run,
                           {{"images", std::make_shared<stored_png::Codec>()}});
        return *Files::load({out / "figures", out});
    }

    testing::TemporaryFolder folder;
    std::shared_ptr<Mesh> mesh = std::make_shared<Mesh>();
    std::shared_ptr<Frames> frames = std::make_shared<Frames>();
    std::shared_ptr<Files> views = std::make_shared<Files>();
};
}  // namespace

TEST_CASE("the stage measures the circles of renders, and draws them")
{
    const Recording recording(784);
    testing::TestRun run;
    testing::TemporaryFolder out;
    const Files files = recording.judge(Value::Map{{"overlay", true}}, run, out.path());
    CHECK(files.names == std::vector<std::string>{"circles.json", "circles/s_far.png", "circles/s_near.png"});
    const Value figures = parse_json(read_text_file(files.loaded_from / "circles.json"));
    CHECK(figures.at("circles").as_int() == 6);
    CHECK(figures.at("circles_3d").as_int() == 6);
    CHECK(figures.at("stretch").at("value").as_double() == Approx(1).margin(0.03));
    // Depths 2 and 1 m, radii 15, 18, 12 and 30, 36, 24 px; the same sizes in meters at both.
    CHECK(figures.at("corr_2d").at("value").as_double() == Approx(-0.8885).margin(0.02));
    CHECK(figures.at("corr_3d").at("value").as_double() == Approx(0).margin(0.05));
    CHECK(figures.at("picture_circles").as_list().size() == 2);
    CHECK(figures.at("picture_circles").as_list()[1].at("circles").as_list().size() == 3);
    CHECK(run.reported.at("corr_2d") == figures.at("corr_2d"));
    CHECK(std::ranges::any_of(run.messages, [](const auto& line) { return line.starts_with("Corr2D -0.8"); }));

    testing::TemporaryFolder half;
    testing::TestRun every_second;
    const Value fewer = parse_json(
        read_text_file(recording.judge(Value::Map{{"every", 2}}, every_second, half.path()).loaded_from / "circles.json"));
    CHECK(fewer.at("pictures").as_int() == 1);
    CHECK(fewer.at("circles").as_int() == 3);

    testing::TemporaryFolder again;
    testing::TestRun one(1);
    const Files same = recording.judge(Value::Map{{"overlay", true}}, one, again.path());
    for (const std::string& name : files.names)
        CHECK(read_file(files.loaded_from / name) == read_file(same.loaded_from / name));
}

TEST_CASE("the stage refuses low pictures and stops when asked")
{
    const Recording low(300);
    testing::TestRun run;
    testing::TemporaryFolder out;
    CHECK_THROWS_WITH(low.judge(Value::Map{}, run, out.path()),
                      Catch::Contains("is 300 px high") && Catch::Contains("height_px: 784"));
    run.cancel_after(1);
    CHECK_THROWS_AS(low.judge(Value::Map{}, run, out.path()), Canceled);
}
