#include "catch.h"
#include "painted_corner.h"
#include "plugin_under_test.h"
#include "raw_images.h"

#include <fresco/files.h>
#include <fresco/frames.h>
#include <fresco/testing.h>

using namespace painted_corner;

namespace
{

std::shared_ptr<const Frames> aligned(const Mesh& mesh, const Frames& frames, testing::TestRun& run, Table* agreement = nullptr)
{
    testing::TemporaryFolder folder;
    testing::run_stage(FRESCO_PLUGIN_FILE, "frames.align", Value::Map{},
                       {{"mesh", std::make_shared<Mesh>(mesh)}, {"frames", std::make_shared<Frames>(frames)}}, folder.path(), run,
                       {{"image_io", std::make_shared<testing::RawImages>()}});
    if (agreement)
        *agreement = *Table::load({folder.path() / "agreement", folder.path()});
    return Frames::load({folder.path() / "frames", folder.path()});
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "the stage corrects the color cameras and nothing else")
{
    Frames frames;
    const auto truth = cameras();
    for (std::size_t i = 0; i < truth.size(); ++i)
    {
        Frame frame =
            testing::frame("frame-" + std::to_string(i), i == 4 ? mistaken(truth[i], 0.015, {0.01, 0, 0.01}) : truth[i]);
        testing::set_color_picture(frame, folder.path(), picture_of(truth[i]));
        frames.frames.push_back(frame);
    }
    const Mesh mesh = mesh_of(0.04);
    Table agreement;
    const auto found = aligned(mesh, frames, run, &agreement);
    REQUIRE(found->frames.size() == 7);
    CHECK(apart_px(truth[4], frames.frames[4].color) > 3);
    // They may all have moved together.
    const RigidTransform moved = found->frames[0].color.world_from_camera * truth[0].world_from_camera.inverse();
    CHECK(apart_px(truth[4], {truth[4].intrinsics, moved.inverse() * found->frames[4].color.world_from_camera}) < 0.7);
    CHECK(found->frames[4].depth == frames.frames[4].depth);
    CHECK(found->frames[4].color_picture.path == frames.frames[4].color_picture.path);
    CHECK(found->frames[4].color.world_from_camera.rotation_error() < 1e-12);
    CHECK(run.reported.at("most_moved_px").as_double() > 3);
    CHECK(run.reported.at("error_after").as_double() < 0.5 * run.reported.at("error_before").as_double());
    CHECK(run.reported.at("blind_frames").as_int() == 0);
    REQUIRE(agreement.rows.size() == 1);
    for (std::size_t i = 0; i < agreement.columns.size(); ++i)
        CHECK(agreement.rows[0][i] == run.reported.at(agreement.columns[i]));
    REQUIRE(run.messages.size() == 1);
    CHECK(run.messages[0].find("px at most; they differ by ") != std::string::npos);

    // Behind the walls nothing is seen.
    for (auto& frame : frames.frames)
        frame.color.world_from_camera.translation.z += 5;
    CHECK(aligned(mesh, frames, run)->frames[4].color == frames.frames[4].color);
    CHECK(run.messages.back().find("7 of 7 frames see no point") != std::string::npos);
    CHECK_THROWS_WITH(aligned(mesh, Frames(), run), Catch::Contains("has no frames"));
}
