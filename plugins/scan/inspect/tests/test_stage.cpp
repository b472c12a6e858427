#include "catch.h"
#include "recordings.h"

#include <fresco/files.h>
#include <fresco/files_io.h>

using namespace fresco;

namespace
{

std::shared_ptr<Files> inspection_of(const std::shared_ptr<Mesh>& mesh, const std::shared_ptr<Frames>& frames,
                                     const std::shared_ptr<ImageIo>& images, Value options, const std::filesystem::path& out,
                                     testing::TestRun& run)
{
    testing::run_stage(FRESCO_PLUGIN_FILE, "scan.inspect", options, {{"mesh", mesh}, {"frames", frames}}, out, run,
                       {{"image_io", images}});
    return Files::load({out / "pictures", {}});
}

}  // namespace

TEST_CASE("the stage reports, draws, and warns of a mistake or fails by it", "[scan.inspect]")
{
    const auto* room = recordings::room();
    if (room == nullptr)
        return;
    const testing::TemporaryFolder out;
    testing::TestRun right;
    const auto files = inspection_of(room->mesh, room->frames, room->images,
                                     Value::Map{{"frames_count", 5}, {"path", "look/at.png"}}, out.path(), right);
    CHECK(files->names == std::vector<std::string>{"look/at.png", "look/at.json"});
    CHECK(right.reported.at("causes").as_list().empty());
    CHECK(right.reported.at("frames").as_int() == 5);
    CHECK(right.reported.at("agreement").as_double() > 0.9);
    REQUIRE(right.messages.size() == 1);
    CHECK_THAT(right.messages.front(), Contains("mesh and frames agree: ") && Contains("of the depths; 9"));
    // Four rows of four tiles of 240 px.
    const auto sheet = room->images->read_rgb(out.path() / "pictures" / files->names[0]);
    CHECK(sheet.width == 4 + 4 * 324);
    CHECK(sheet.height == 4 + 4 * 244);
    const auto json = parse_json(read_text_file(out.path() / "pictures" / files->names[1]));
    CHECK(json.at("recorded").at("agreement").as_double() == right.reported.at("agreement").as_double());

    auto turned = std::make_shared<Frames>(*room->frames);
    for (Frame& frame : turned->frames)
        for (Camera* camera : {&frame.color, &frame.depth})
            for (const int row : {0, 1, 2})
                for (const int column : {1, 2})
                    camera->world_from_camera.rotation(row, column) *= -1;
    testing::TestRun wrong;
    inspection_of(room->mesh, turned, room->images, Value::Map{}, out.path(), wrong);
    REQUIRE(wrong.reported.at("causes").as_list().size() == 1);
    CHECK(wrong.reported.at("causes").as_list().front().as_string() == "opengl_axes");
    CHECK(wrong.reported.at("agreement_explained").as_double() > 0.9);
    REQUIRE(wrong.messages.size() == 2);
    CHECK_THAT(wrong.messages.front(), Contains("warning: ") && Contains("OpenGL's camera axes"));
    // As recorded and, below each, as suggested.
    CHECK(room->images->read_rgb(out.path() / "pictures" / "inspect.png").height == 4 + 8 * 244);

    testing::TestRun failing;
    CHECK_THROWS_WITH(inspection_of(room->mesh, turned, room->images, Value::Map{{"fail", true}}, out.path(), failing),
                      Contains("OpenGL's camera axes") && Contains("inspect.png shows it"));
    CHECK(std::filesystem::exists(failing.preview_folder() / "inspect.png"));
}

TEST_CASE("frames need neither depth nor pictures, but there must be some", "[scan.inspect]")
{
    const auto* room = recordings::room();
    if (room == nullptr)
        return;
    const testing::TemporaryFolder out;
    auto frames = std::make_shared<Frames>(*room->frames);
    for (Frame& frame : frames->frames)
        frame.depth_picture = {};
    testing::TestRun run;
    inspection_of(room->mesh, frames, room->images, Value::Map{}, out.path(), run);
    CHECK(run.reported.at("causes").as_list().empty());
    CHECK_THAT(run.messages.back(), Contains("mesh and frames agree: the pictures' edges"));
    for (Frame& frame : frames->frames)
        frame.color_picture = {};
    testing::TestRun blind;
    inspection_of(room->mesh, frames, room->images, Value::Map{}, out.path(), blind);
    CHECK(blind.reported.at("edge_response").as_double() == 0);
    CHECK_THAT(blind.messages.back(), Contains("nothing to compare"));

    CHECK_THROWS_WITH(inspection_of(room->mesh, std::make_shared<Frames>(), room->images, Value::Map{}, out.path(), run),
                      Contains("has no frames"));
    testing::TestRun stopped;
    stopped.cancel_after(30);
    CHECK_THROWS_AS(inspection_of(room->mesh, room->frames, room->images, Value::Map{}, out.path(), stopped), Canceled);
}
