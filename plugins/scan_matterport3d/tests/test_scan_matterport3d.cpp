#include "house.h"
#include "house_cameras.h"

#include "reader_damage.h"

#include <fresco/mesh_io.h>

#include <catch2/catch.hpp>

#include <algorithm>

namespace fs = std::filesystem;
using Catch::Contains;
using fresco::Value;
using fresco::testing::RawImages;
using fresco::testing::TestRun;

namespace
{

struct TinyHouse
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;
    fresco::Frames frames = fresco::testing::tiny_recording(folder.path(), images);

    TinyHouse()
    {
        fresco::testing::write_matterport3d(frames, path(), images);
        write_mesh("house_segmentations/tiny.ply", 2);
        write_mesh("region_segmentations/region1.ply", 1);
    }
    fs::path path() const { return folder.path() / "tiny"; }
    fs::path cameras() const { return path() / "undistorted_camera_parameters/tiny.conf"; }
    fs::path house() const { return path() / "house_segmentations/tiny.house"; }
    void write_mesh(const std::string& name, std::size_t faces) const
    {
        fresco::Mesh mesh;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
        mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
        mesh.triangles.resize(faces);
        fs::create_directories((path() / name).parent_path());
        fresco::write_file(path() / name, fresco::to_ply(mesh));
    }
    /// With a part of a file replaced.
    void edit(const fs::path& file, const std::string& from, const std::string& to) const
    {
        auto text = fresco::read_text_file(file);
        const auto at = text.find(from);
        REQUIRE(at != std::string::npos);
        fresco::write_file(file, text.replace(at, from.size(), to));
    }
};

fresco::testing::ReadScan read(const TinyHouse& house, TestRun& run, const Value& options = Value::Map{})
{
    return fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.matterport3d", house.path(), house.images,
                                       house.folder.path() / "out", run, options);
}

std::string error_of(const TinyHouse& house, const Value& options = Value::Map{})
{
    return fresco::testing::reading_error([&](TestRun& run) { read(house, run, options); });
}

}  // namespace

TEST_CASE("a house is read back", "[scan.matterport3d]")
{
    const TinyHouse house;
    TestRun run;
    const auto result = read(house, run);
    fresco::testing::check_same_recording(*result.frames, house.frames, house.images, 1e-6);
    CHECK(result.frames->frames[2].sequence == "tiny");
    CHECK(result.frames->frames[2].name == "03a8325e000002_i1_0");
    CHECK(result.frames->frames[2].number == 2);
    CHECK(result.frames->frames[2].depth_unit_m == 0.00025);
    CHECK(result.mesh->triangles.size() == 2);
    CHECK(run.reported.at("house").as_string() == "tiny");
    CHECK(run.files_read.size() == 2 + 2 * 3);
    CHECK(read(house, run, Value::Map{{"every", 2}}).frames->frames[1].number == 2);
}

TEST_CASE("a room is its mesh and the pictures taken in it", "[scan.matterport3d]")
{
    const TinyHouse house;
    TestRun run;
    const auto result = read(house, run, Value::Map{{"region", 1}});
    REQUIRE(result.frames->frames.size() == 1);
    CHECK(result.frames->frames[0].number == 1);
    CHECK(result.mesh->triangles.size() == 1);
    CHECK(run.reported.at("house_frames").as_int() == 3);
    CHECK_THAT(error_of(house, Value::Map{{"region", 0}}), Contains("the mesh is missing") && Contains("region0.ply"));
    CHECK(error_of(house, Value::Map{{"region", 0}, {"mesh", (house.path() / "region_segmentations/region1.ply").string()}}) ==
          "no error");
    CHECK_THAT(error_of(house, Value::Map{{"region", 7}}), Contains("no picture was taken in region 7"));
    fs::remove(house.house());
    CHECK_THAT(error_of(house, Value::Map{{"region", 1}}), Contains("tiny.house"));
    CHECK(error_of(house) == "no error");
}

TEST_CASE("the mesh of the house may be the Poisson one", "[scan.matterport3d]")
{
    const TinyHouse house;
    fs::remove(house.path() / "house_segmentations/tiny.ply");
    CHECK_THAT(error_of(house), Contains("the mesh is missing") && Contains("house_segmentations/tiny.ply or ") &&
                                    Contains("poisson_meshes/tiny.ply"));
    house.write_mesh("poisson_meshes/tiny.ply", 1);
    fs::remove_all(house.path() / "house_segmentations");
    TestRun run;
    CHECK(read(house, run).mesh->triangles.size() == 1);
    // Names that may appear are asked for in folders that are there.
    CHECK(std::ranges::find(run.folders_read, house.path() / "house_segmentations") != run.folders_read.end());
}

TEST_CASE("rows count from the bottom, axes are OpenGL's", "[scan.matterport3d]")
{
    const auto house =
        matterport3d::parse_cameras("dataset matterport\nn_images 1\n\nintrinsics_matrix 1076.45 0 631.116  0 1077.19 509.202  "
                                    "0 0 1\nscan a_d0_0.png a_i0_0.jpg 1 0 0 4  0 0 -1 5  0 1 0 6  0 0 0 1\n",
                                    "x.conf");
    REQUIRE(house.views.size() == 1);
    const auto& view = house.views[0];
    CHECK(view.panorama == "a");
    const auto k = matterport3d::camera_of(view, 1280, 1024, matterport3d::ImageOrigin::bottom_left);
    CHECK(k.fx == 1076.45);
    CHECK(k.cx == Approx(631.616));
    CHECK(k.cy == Approx(1024 - 509.702));
    CHECK(matterport3d::camera_of(view, 1280, 1024, matterport3d::ImageOrigin::top_left).cy == Approx(509.702));
    // It looks along its own -z, which is the world's y, and the world's z is up in its picture.
    CHECK(view.world_from_camera.point({0, 0, 1}) == fresco::Vec3d{4, 6, 6});
    CHECK(view.world_from_camera.direction({0, -1, 0}) == fresco::Vec3d{0, 0, 1});
    CHECK(view.source == "x.conf:5");

    const auto regions = matterport3d::parse_regions("ASCII 1.1\nH h - 3 2 0 0 0 0 0 4 1 1\nP 0 2 3 - 1 2 3 4 5 6 0 0 0 0\n"
                                                     "P aa 0 3 0 1 2 3 0 0 0 0 0\nP bb 1 -1 0 1 2 3 0 0 0 0 0\nI 0 0 aa\n",
                                                     "h.house");
    CHECK(regions == std::map<std::string, int>{{"aa", 3}, {"bb", -1}});
}

TEST_CASE("a house that cannot be used is refused by name", "[scan.matterport3d]")
{
    const TinyHouse house;
    SECTION("no camera file")
    {
        fs::remove(house.cameras());
        CHECK_THAT(error_of(house), Contains("undistorted_camera_parameters: no camera file; expected <house>.conf"));
    }
    SECTION("two camera files")
    {
        fs::copy_file(house.cameras(), house.cameras().parent_path() / "other.conf");
        CHECK_THAT(error_of(house), Contains("2 camera files") && Contains("other.conf"));
    }
    SECTION("another number of views")
    {
        house.edit(house.cameras(), "n_images 3", "n_images 4");
        CHECK_THAT(error_of(house), Contains("tiny.conf: n_images promises 4 views, there are 3"));
    }
    SECTION("another number of panoramas")
    {
        house.edit(house.house(), "H tiny - 3 3", "H tiny - 3 5");
        CHECK_THAT(error_of(house, Value::Map{{"region", 1}}), Contains("promises 5 panoramas, there are 3"));
    }
    SECTION("a panorama that the house does not know")
    {
        house.edit(house.house(), "P 03a8325e000001", "P 03a8325e000009");
        CHECK_THAT(error_of(house, Value::Map{{"region", 1}}), Contains("panorama 03a8325e000001 of") && Contains("tiny.conf:"));
    }
    SECTION("another line")
    {
        house.edit(house.cameras(), "dataset", "data");
        CHECK_THAT(error_of(house), Contains("tiny.conf:1: 'data' where dataset, n_images"));
    }
    SECTION("values missing")
    {
        house.edit(house.cameras(), "dataset matterport", "scan a.png b.jpg 1 2");
        CHECK_THAT(error_of(house), Contains("tiny.conf:1: 4 values behind 'scan' where 18 were expected"));
    }
    SECTION("a view before intrinsics")
    {
        house.edit(house.cameras(), "dataset matterport", "scan a.png b.jpg 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
        CHECK_THAT(error_of(house), Contains("tiny.conf:1: a scan before any intrinsics_matrix"));
    }
    SECTION("a name that leads elsewhere")
    {
        house.edit(house.cameras(), "03a8325e000001_i1_0.jpg", "../../secret.jpg");
        CHECK_THAT(error_of(house), Contains("'../../secret.jpg' is no plain name"));
        house.edit(house.cameras(), "color_directory undistorted_color_images", "color_directory ..");
        CHECK_THAT(error_of(house), Contains("'..' is no plain name"));
    }
    SECTION("no rigid pose")
    {
        house.edit(house.cameras(), " 0.0 0.0 0.0 1.0\n", " 0.0 0.0 1.0 1.0\n");
        CHECK_THAT(error_of(house), Contains("tiny.conf:7: "));
    }
    SECTION("a picture missing")
    {
        fs::remove(house.path() / "undistorted_depth_images/03a8325e000001_d1_0.png");
        CHECK_THAT(error_of(house), Contains("03a8325e000001_d1_0.png"));
    }
}

TEST_CASE("damage to a house gives an error or what can be used", "[scan.matterport3d]")
{
    const TinyHouse house;
    const auto path = house.path();
    const auto out = house.folder.path() / "out";
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.matterport3d", path, house.images, out,
                                  {{house.cameras(), 200, 150},
                                   {path / "undistorted_color_images/03a8325e000001_i1_0.jpg"},
                                   {path / "undistorted_depth_images/03a8325e000002_d1_0.png"},
                                   {path / "house_segmentations/tiny.ply", 200, 100}});
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.matterport3d", path, house.images, out,
                                  {{house.house(), 200, 100}, {path / "region_segmentations/region1.ply", 200, 100}},
                                  Value::Map{{"region", 1}});
}
