#include "catch.h"
#include "pictures.h"
#include "stored_png.h"
#include <fresco/testing_scenes.h>

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

using namespace fresco;
using namespace pictures;

namespace
{
constexpr int width = 160;
constexpr int height = 120;

void write_picture(const std::filesystem::path& file, const Raster8& picture)
{
    const auto png = stored_png::encode(picture);
    write_file(file, std::as_bytes(std::span(png)));
}

/// Three views of rooms that look painted, blurred only by chance, and one that shows hardly anything.
class Recording
{
  public:
    Recording()
    {
        style->pixels = painting(256, 256, 7);
        for (int i = 0; i < 4; ++i)
        {
            const std::string name = "f" + std::to_string(i);
            const Raster8 camera = photograph(width, height, static_cast<std::uint64_t>(i));
            Frame frame = testing::frame(name, testing::camera(width, height, 150));
            frame.color_picture.path = folder.path() / ("camera_" + name + ".png");
            write_picture(frame.color_picture.path, camera);
            frames->frames.push_back(frame);
            // Strokes laid over what the camera saw; the last view is all hole.
            const Raster8 strokes = painting(width, height, 20U + static_cast<unsigned>(i));
            const Raster8 room = recolored(camera, style->pixels);
            const Raster8 view =
                changed(room, [&](int x, int y) { return color_at(room, x, y) * 0.5F + color_at(strokes, x, y) * 0.5F; });
            views->names.push_back("seq-01_" + name + ".png");
            write_picture(folder.path() / views->names.back(), with_hole(view, i == 3 ? 95 : 10));
        }
        views->loaded_from = folder.path();
    }

    Value judge(const Value& options, const testing::Inputs& inputs, testing::TestRun& run) const
    {
        testing::TemporaryFolder out;
        testing::run_stage(FRESCO_PLUGIN_FILE, "evaluate.painting", options, inputs, out.path(), run,
                           {{"image_io", std::make_shared<stored_png::Codec>()}});
        const auto files = Files::load({out.path() / "figures", out.path()});
        REQUIRE(files->names.size() == 1);
        return parse_json(read_text_file(files->loaded_from / files->names[0]));
    }

    testing::Inputs all_views() const { return {{"views", views}, {"frames", frames}, {"style", style}}; }

    testing::TemporaryFolder folder;
    std::shared_ptr<Image> style = std::make_shared<Image>();
    std::shared_ptr<Frames> frames = std::make_shared<Frames>();
    std::shared_ptr<Files> views = std::make_shared<Files>();
};

/// A wall whose charts have colors of their own, the start without, and a map that uses the whole picture.
struct PaintedWall
{
    PaintedWall()
    {
        Random random(1);
        mesh->mesh = testing::two_chart_wall();
        *start = testing::blank_texture(32, 0);
        mesh->image.pixels = testing::picture(
            64, 64, [&](int x, int, int c) { return c == 0 && x >= 32 ? 220.0 : 100.0 + static_cast<double>(random.below(10)); });
        for (float& v : start->layers.front().values)
            v = static_cast<float>(random.uniform());
        std::ranges::fill(start->seen.values, std::uint8_t{1});
        start->atlas = source->atlas = atlas_id(mesh->mesh);
        source->picture_width = source->picture_height = 64;
        source->clear(64);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                source->set_place(x, y, {{static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F}, 0});
    }
    std::shared_ptr<TexturedMesh> mesh = std::make_shared<TexturedMesh>();
    std::shared_ptr<Texture> start = std::make_shared<Texture>();
    std::shared_ptr<SourceMap> source = std::make_shared<SourceMap>();
};

bool has_line(const testing::TestRun& run, std::string_view beginning)
{
    return std::ranges::any_of(run.messages, [&](const std::string& line) { return line.starts_with(beginning); });
}
}  // namespace

TEST_CASE("the stage reports mean and worst view, as JSON and as a table")
{
    const Recording recording;
    testing::TestRun run;
    const Value result = recording.judge(Value::Map{}, recording.all_views(), run);
    CHECK(result.at("views").as_int() == 3);
    CHECK(result.at("views_skipped").as_int() == 1);
    const Value& list = result.at("view_figures");
    REQUIRE(list.as_list().size() == 4);
    CHECK(list.as_list()[3].at("skipped").as_bool());
    CHECK(list.as_list()[3].find("strokes") == nullptr);
    for (const char* name : {"off_palette", "coherence", "chroma_noise", "strokes", "edges"})
    {
        const Value& figure = result.at("figures").at(name);
        double sum = 0;
        bool has_worst = false;
        for (int i = 0; i < 3; ++i)
        {
            const Value& view = list.as_list()[static_cast<std::size_t>(i)];
            sum += view.at(name).as_double();
            has_worst = has_worst || (view.at(name) == figure.at("worst") && view.at("view") == figure.at("worst_view"));
        }
        CAPTURE(name);
        CHECK(figure.at("mean").as_double() == Approx(sum / 3));
        CHECK(has_worst);
        CHECK(run.reported.at(name) == figure.at("mean"));
    }
    CHECK(result.at("figures").at("edges").at("mean").as_double() > 0.5);
    CHECK(run.reported.at("table").at("rows").as_list().size() == 6);
    CHECK(has_line(run, "off_palette "));
    CHECK(has_line(run, "1 of 4 views skipped"));
    CHECK(std::ranges::any_of(run.messages,
                              [](const auto& line) { return line.find("of 6 figures in the wanted range") != line.npos; }));
    // Nothing of what was not wired.
    CHECK(result.at("figures").find("seams") == nullptr);
    CHECK(result.find("seam_ratio") == nullptr);
}

TEST_CASE("each figure needs its own inputs only")
{
    const Recording recording;
    testing::TestRun run;
    const Value edges = recording.judge(Value::Map{}, {{"views", recording.views}, {"frames", recording.frames}}, run);
    CHECK(edges.at("figures").as_map().size() == 2);
    CHECK(edges.at("figures").find("edges") != nullptr);
    // Without frames, every picture of a folder, here also the cameras'.
    const Value folder = recording.judge(Value::Map{{"folder", recording.folder.path().string()}, {"every", 2}},
                                         {{"style", recording.style}}, run);
    CHECK(folder.at("figures").as_map().size() == 4);
    REQUIRE(folder.at("view_figures").as_list().size() == 4);
    CHECK(folder.at("view_figures").as_list()[0].at("view").as_string() == "camera_f0");
    CHECK(folder.at("view_figures").as_list()[2].at("view").as_string() == "seq-01_f0");
    CHECK(run.files_read.size() == 8);
    // Frames whose pictures were left behind.
    const auto bare = std::make_shared<Frames>(*recording.frames);
    for (Frame& frame : bare->frames)
        frame.color_picture = {};
    testing::Inputs inputs = recording.all_views();
    inputs["frames"] = bare;
    CHECK(recording.judge(Value::Map{}, inputs, run).at("figures").find("edges") == nullptr);
}

TEST_CASE("seams and the use of the picture, without any view")
{
    const Recording recording;
    const PaintedWall wall;
    testing::TestRun run;
    const Value result =
        recording.judge(Value::Map{}, {{"textured_mesh", wall.mesh}, {"start", wall.start}, {"source", wall.source}}, run);
    const double seams = result.at("figures").at("seams").at("value").as_double();
    CHECK(seams > 3);
    CHECK(seams == Approx(result.at("seam_ratio").as_double() / result.at("start_seam_ratio").as_double()));
    CHECK(run.reported.at("start_seam_ratio") == result.at("start_seam_ratio"));
    CHECK(result.at("seam_distance_m").as_double() == Approx(2 / (0.3 * 32)));
    CHECK(result.at("figures").at("picture_used").at("value").as_double() == 1);
    CHECK(result.at("figures").at("largest_share").at("reached").as_bool());
    CHECK(result.find("views") == nullptr);

    CHECK(result.at("figures").find("repeats") == nullptr);

    // A coherent copy of the picture, in both charts.
    wall.source->picture_width = wall.source->picture_height = 256;
    const testing::Inputs with_style{{"textured_mesh", wall.mesh}, {"source", wall.source}, {"style", recording.style}};
    const Value coherent = recording.judge(Value::Map{}, with_style, run);
    CHECK(coherent.at("figures").at("repeats").at("value").as_double() == 0);
    CHECK(coherent.at("figures").at("weave").at("reached").as_bool());

    const Value alone = recording.judge(Value::Map{}, {{"textured_mesh", wall.mesh}}, run);
    CHECK(alone.at("seam_ratio").as_double() > 3);
    CHECK(alone.at("figures").as_map().empty());
    CHECK(has_line(run, "seam_ratio "));

    wall.start->layers.front() = RasterF(32, 32, 3, 0.5F);
    const Value plain = recording.judge(Value::Map{}, {{"textured_mesh", wall.mesh}, {"start", wall.start}}, run);
    CHECK(plain.at("figures").find("seams") == nullptr);
    CHECK(plain.at("start_seam_ratio").is_null());
    CHECK(has_line(run, "warning: the texture on port 'start'"));

    for (Vec3f& p : wall.mesh->mesh.positions)
        if (p.x > 1)
            p = {1, p.y, p.x - 1};
    wall.start->atlas.clear();
    recording.judge(Value::Map{}, {{"textured_mesh", wall.mesh}, {"start", wall.start}}, run);
    CHECK(has_line(run, "the atlas has no seams but creases"));
}

TEST_CASE("the stage says what is missing or does not belong together")
{
    const Recording recording;
    const PaintedWall wall;
    testing::TestRun run;
    const auto refused = [&](const testing::Inputs& inputs, const std::string& text, const Value& options = Value::Map{})
    { CHECK_THROWS_WITH(recording.judge(options, inputs, run), Catch::Contains(text)); };
    const Value folder = Value::Map{{"folder", recording.folder.path().string()}};
    refused({}, "nothing to measure");
    refused({{"style", recording.style}}, "port 'style' is compared with views");
    refused({{"frames", recording.frames}}, "port 'frames' is compared with views");
    refused({{"views", recording.views}}, "wire one of them or both");
    refused(recording.all_views(), "either port 'views'", folder);
    refused({{"views", recording.views}, {"start", wall.start}, {"style", recording.style}}, "wire 'textured_mesh'");

    refused({{"textured_mesh", wall.mesh}, {"source", wall.source}, {"style", recording.style}},
            "has places in a picture of 64 x 64, the one on port 'style' is 256 x 256");

    wall.start->atlas = "another";
    refused({{"textured_mesh", wall.mesh}, {"start", wall.start}}, "the texture on port 'start'");
    wall.source->atlas = "another";
    refused({{"textured_mesh", wall.mesh}, {"source", wall.source}}, "the map on port 'source'");
    wall.mesh->image.pixels = Raster8(64, 32, 3);
    refused({{"textured_mesh", wall.mesh}}, "expected a square RGB picture");
    wall.mesh->mesh.texcoords.clear();
    refused({{"textured_mesh", wall.mesh}}, "has no texcoords");

    const auto none = std::make_shared<Files>();
    refused({{"views", none}, {"style", recording.style}}, "no pictures on port 'views'");
    for (const std::string& name : recording.views->names)
        write_picture(recording.folder.path() / name, Raster8(60, 45, 4, 255));
    refused(recording.all_views(), "none of the 4 views shows enough");
    write_picture(recording.folder.path() / recording.views->names[0], Raster8(60, 60, 4, 255));
    refused(recording.all_views(), "pictures must show the camera's whole view");
    const Recording whole;
    run.cancel_after(2);
    CHECK_THROWS_AS(whole.judge(Value::Map{}, whole.all_views(), run), Canceled);
}

TEST_CASE("the size of strokes is compared with the one asked for")
{
    const Recording recording;
    const PaintedWall wall;
    testing::TestRun run;
    const testing::Inputs inputs{{"textured_mesh", wall.mesh}, {"style", recording.style}};
    const Value found = recording.judge(Value::Map{{"stroke_cm", 4.0}}, inputs, run).at("figures").at("stroke_cm");
    CHECK(found.at("at_least").as_double() == Approx(3.4));
    CHECK(found.at("at_most").as_double() == Approx(4.6));
    CHECK(std::isfinite(found.at("value").as_double()));
    const Value wide = recording.judge(Value::Map{{"stroke_cm", 90.0}}, inputs, run);
    CHECK(wide.at("figures").find("stroke_cm") == nullptr);
    CHECK(has_line(run, "warning: the surface has only 0 flat places as wide as five strokes of 90 cm"));

    const auto refused = [&](const Value& options, const testing::Inputs& given, const std::string& text)
    { CHECK_THROWS_WITH(recording.judge(options, given, run), Catch::Contains(text)); };
    refused(Value::Map{{"stroke_cm", 4.0}}, {{"textured_mesh", wall.mesh}}, "wire 'textured_mesh' and 'style'");
    const auto maps = std::make_shared<UvMaps>();
    refused(Value::Map{}, {{"textured_mesh", wall.mesh}, {"uvmaps", maps}}, "set option \"stroke_cm\"");
    maps->atlas = "another";
    refused(Value::Map{{"stroke_cm", 4.0}}, {{"textured_mesh", wall.mesh}, {"style", recording.style}, {"uvmaps", maps}},
            "the uv maps on port 'uvmaps'");
}
