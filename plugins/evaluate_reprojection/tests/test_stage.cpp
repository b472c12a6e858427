#include "catch.h"
#include "stored_png.h"
#include "wall_scene.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace wall_scene;

namespace
{
/// Six recorded frames, numbers 0, 8, …, 40, that move by 2.5 px each, and their renders.
class Recording
{
  public:
    Recording()
    {
        Random random(1);
        textured =
            std::make_shared<TexturedMesh>(wall(picture(300, 300, [&](int, int, int) { return 128 + 40 * random.normal(); })));
        for (int i = 0; i < 6; ++i)
        {
            Frame frame;
            frame.sequence = "seq-01";
            frame.number = 8 * i;
            frame.name = "frame-" + std::to_string(frame.number);
            frame.color = frame.depth = camera(48, 36, 2.5 * i, 0.3 * i);
            frames->frames.push_back(frame);
            views->names.push_back("seq-01_" + frame.name + ".png");
            write_file(folder.path() / views->names.back(), stored_png::Codec().encode_png(render(*textured, frame.color)));
        }
        views->loaded_from = folder.path();
    }

    testing::Inputs rendered() const { return {{"views", views}, {"frames", frames}, {"textured_mesh", textured}}; }

    std::string judge(const Value& options, const testing::Inputs& inputs, testing::TestRun& run) const
    {
        testing::TemporaryFolder out;
        testing::run_stage(FRESCO_PLUGIN_FILE, "evaluate.reprojection", options, inputs, out.path(), run,
                           {{"images", std::make_shared<stored_png::Codec>()}});
        const auto files = Files::load({out.path() / "figures", out.path()});
        REQUIRE(files->names.size() == 1);
        return read_text_file(files->loaded_from / files->names[0]);
    }

    testing::TemporaryFolder folder;
    std::shared_ptr<TexturedMesh> textured;
    std::shared_ptr<Frames> frames = std::make_shared<Frames>();
    std::shared_ptr<Files> views = std::make_shared<Files>();
};

const Value kitchen_gaps = Value::Map{{"short_gap", 8}, {"long_gap", 24}};
}  // namespace

TEST_CASE("the stage judges renders by gaps in recorded numbers")
{
    const Recording recording;
    testing::TestRun run;
    const Value figures = parse_json(recording.judge(kitchen_gaps, recording.rendered(), run));
    CHECK(figures.at("floor_of").as_string() == "texture");
    CHECK(figures.at("short").at("pairs").as_int() == 5);
    CHECK(figures.at("short").at("frames_without_target").as_int() == 1);
    CHECK(figures.at("long").at("pairs").as_int() == 3);
    CHECK(figures.at("long").at("pair_figures").as_list().size() == 3);
    const Value& value = figures.at("short").at("value");
    CHECK(value.at("value").as_double() > 0.02);
    CHECK(value.at("low").as_double() <= value.at("value").as_double());
    CHECK(value.at("high").as_double() >= value.at("value").as_double());
    CHECK(std::abs(figures.at("short").at("headline").at("value").as_double()) < 0.01);
    CHECK(run.reported.at("short_value").at("value") == value.at("value"));
    CHECK(run.reported.at("long_dropped_pairs").as_int() == 0);
    CHECK(std::ranges::any_of(run.messages, [](const auto& line) { return line.starts_with("short value 0.0"); }));
}

TEST_CASE("every n-th picture's pairs are those of the whole run")
{
    const Recording recording;
    testing::TestRun run;
    const Value all = parse_json(recording.judge(kitchen_gaps, recording.rendered(), run));
    Value options = kitchen_gaps;
    options.set("every", 2);
    const Value some = parse_json(recording.judge(options, recording.rendered(), run));
    CHECK(some.at("short").at("pairs").as_int() == 3);
    CHECK(some.at("short").at("frames_without_target").as_int() == 1);
    CHECK(some.at("short").at("pair_figures").as_list()[1] == all.at("short").at("pair_figures").as_list()[2]);
}

TEST_CASE("a folder of pictures is judged with a plain mesh")
{
    const Recording recording;
    testing::TestRun run;
    Value options = kitchen_gaps;
    options.set("folder", recording.folder.path().string());
    const auto mesh = std::make_shared<Mesh>(recording.textured->mesh);
    const Value figures = parse_json(recording.judge(options, {{"frames", recording.frames}, {"mesh", mesh}}, run));
    CHECK(figures.at("floor_of").as_string() == "picture");
    CHECK(figures.at("short").at("pairs").as_int() == 5);
    CHECK(run.files_read.size() == 6);
}

TEST_CASE("the released protocol measures squares by list positions at 256 px")
{
    const Recording recording;
    testing::TestRun run;
    const Value figures =
        parse_json(recording.judge(Value::Map{{"protocol", "released"}, {"long_gap", 3}}, recording.rendered(), run));
    CHECK(figures.at("short").at("pairs").as_int() == 6);  // each frame has one before or behind it
    CHECK(figures.at("short").at("gap").as_int() == 1);
    CHECK(figures.at("long").at("pairs").as_int() == 6);
    CHECK(figures.at("short").at("value").at("value").as_double() > 1);  // of 255 squared
}

TEST_CASE("a flat texture is warned about")
{
    const Recording recording;
    for (const std::string& name : recording.views->names)
        write_file(recording.folder.path() / name, stored_png::Codec().encode_png(Raster8(48, 36, 3, 77)));
    testing::TestRun run;
    const Value figures = parse_json(recording.judge(kitchen_gaps, recording.rendered(), run));
    CHECK(figures.at("short").at("invalid").as_bool());
    CHECK(figures.at("short").at("headline").at("value").is_null());
    CHECK(std::ranges::any_of(run.messages,
                              [](const auto& line) { return line.starts_with("warning: the short figures are invalid"); }));
}

TEST_CASE("the stage refuses what it cannot judge")
{
    const Recording recording;
    testing::TestRun run;
    CHECK_THROWS_WITH(recording.judge(Value::Map{}, recording.rendered(), run), Catch::Contains("smallest difference is 8"));
    auto inputs = recording.rendered();
    inputs.erase("textured_mesh");
    CHECK_THROWS_WITH(recording.judge(kitchen_gaps, inputs, run), Catch::Contains("wire one of the ports"));
    inputs["mesh"] = std::make_shared<Mesh>(recording.textured->mesh);
    Value texture_floor = kitchen_gaps;
    texture_floor.set("floor", "texture");
    CHECK_THROWS_WITH(recording.judge(texture_floor, inputs, run), Catch::Contains("choose floor: picture"));
}
