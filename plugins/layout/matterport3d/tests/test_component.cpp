#include "house.h"
#include "layout_test.h"

#include <algorithm>

namespace
{

const char* const cameras_file = "undistorted_camera_parameters/tiny.conf";
const char* const house_file = "house_segmentations/tiny.house";

const LayoutUnderTest layout{.type = "layout.matterport3d",
                             .write =
                                 [](const Frames& frames, const fs::path& folder, const ImageIo& images)
                             {
                                 write_matterport3d(frames, folder, images);
                                 write_mesh(folder / "house_segmentations/tiny.ply", 2);
                                 write_mesh(folder / "region_segmentations/region1.ply", 1);
                                 return folder;
                             },
                             .color = "undistorted_color_images/03a8325e000001_i1_0.jpg",
                             .depth = "undistorted_depth_images/03a8325e000001_d1_0.png",
                             .pose_source = "tiny.conf:10",
                             .damaged = {cameras_file, "house_segmentations/tiny.ply"},
                             .depth_step_m = 1e-6,
                             .third = "tiny 03a8325e000002_i1_0 2",
                             .mesh_faces = 2,
                             .files_read = 2 + 2 * 3};

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("a room is its mesh and the pictures taken in it", "[layout.matterport3d]")
{
    const WrittenRecording house(layout);
    TestRun run;
    const auto result = house.read(run, Value::Map{{"region", 1}});
    REQUIRE(result.frames->frames.size() == 1);
    CHECK(result.frames->frames[0].number == 1);
    CHECK(result.mesh->triangles.size() == 1);
    CHECK(run.reported.at("house_frames").as_int() == 3);
    check_no_mesh(house, "region0.ply", Value::Map{{"region", 0}});
    CHECK(house.error(Value::Map{{"region", 0}, {"mesh", (house.path / "region_segmentations/region1.ply").string()}}) ==
          "no error");
    CHECK_THAT(house.error(Value::Map{{"region", 7}}), Contains("no picture was taken in region 7"));
    house.remove(house_file);
    CHECK_THAT(house.error(Value::Map{{"region", 1}}), Contains("tiny.house"));
    CHECK(house.error() == "no error");
}

TEST_CASE("the mesh of the house may be the Poisson one", "[layout.matterport3d]")
{
    const WrittenRecording house(layout);
    fs::remove(house.path / "house_segmentations/tiny.ply");
    check_no_mesh(house, (house.path / "house_segmentations/tiny.ply").string() + " or " +
                             (house.path / "poisson_meshes/tiny.ply").string());
    write_mesh(house.path / "poisson_meshes/tiny.ply", 1);
    fs::remove_all(house.path / "house_segmentations");
    TestRun run;
    CHECK(house.read(run).mesh->triangles.size() == 1);
    // Names that may appear are asked for in folders that are there.
    CHECK(std::ranges::find(run.folders_read, house.path / "house_segmentations") != run.folders_read.end());
}

TEST_CASE("the room of a panorama is in the house file, -1 where there is none", "[layout.matterport3d]")
{
    const auto regions = matterport3d::parse_regions("ASCII 1.1\nH h - 3 2 0 0 0 0 0 4 1 1\nP 0 2 3 - 1 2 3 4 5 6 0 0 0 0\n"
                                                     "P aa 0 3 0 1 2 3 0 0 0 0 0\nP bb 1 -1 0 1 2 3 0 0 0 0 0\nI 0 0 aa\n",
                                                     "h.house");
    CHECK(regions == std::map<std::string, int>{{"aa", 3}, {"bb", -1}});
}

TEST_CASE("a house that cannot be used is refused by name", "[layout.matterport3d]")
{
    const auto edit = [](const char* from, const char* to)
    { return [=](const WrittenRecording& it) { it.replace(cameras_file, from, to); }; };
    const char* const kind = "dataset matterport";
    check_flaws(layout, {{removing(cameras_file), {"undistorted_camera_parameters: no camera file; expected <house>.conf"}},
                         {[](const auto& it) { it.write("undistorted_camera_parameters/other.conf", it.text(cameras_file)); },
                          {"2 camera files", "other.conf"}},
                         {edit("n_images 3", "n_images 4"), {"tiny.conf: n_images declares 4 views, the file has 3"}},
                         {edit("dataset", "data"), {"tiny.conf:1: 'data'; expected dataset, n_images"}},
                         {edit(kind, "scan a.png b.jpg 1 2"), {"tiny.conf:1: 4 values after 'scan'; expected 18"}},
                         {edit(kind, "scan a.png b.jpg 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"),
                          {"tiny.conf:1: a scan before any intrinsics_matrix"}},
                         {edit("03a8325e000001_i1_0.jpg", "../../secret.jpg"), {"'../../secret.jpg' is not a plain"}},
                         {edit("color_directory undistorted_color_images", "color_directory .."), {"'..' is not a plain"}}});
    check_flaws(layout,
                {{replacing(house_file, "H tiny - 3 3", "H tiny - 3 5"), {"declares 5 panoramas, the file has 3"}},
                 {replacing(house_file, "P 03a8325e000001", "P 03a8325e000009"), {"panorama 03a8325e000001 of", "tiny.conf:"}}},
                Value::Map{{"region", 1}});
    const WrittenRecording house(layout);
    check_damage(house, {house_file, "region_segmentations/region1.ply"}, Value::Map{{"region", 1}});
}
