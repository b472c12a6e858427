#include "catch.h"
#include "masks.h"
#include "plugin_under_test.h"
#include "raw_images.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/regions/regions.h>
#include <fresco/testing_scenes.h>

#include <functional>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

void put(const fs::path& file)
{
    fs::create_directories(file.parent_path());
    write_file(file, "x");
}

std::vector<Frame> frames()
{
    std::vector<Frame> result(3);
    result[0].sequence = result[1].sequence = "seq-01";
    result[2].sequence = "seq-02";
    result[0].name = result[2].name = "frame-000000";
    result[1].name = "frame-000001";
    return result;
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "mask folder: a folder for each region, a picture for each frame")
{
    for (const char* file : {"tv/frame-000001.png", "tv/seq-02_frame-000000.jpg", "tv/.hidden.png", "tv/notes.txt",
                             "plant/seq-01_frame-000000.png", "readme.png"})
        put(folder.path() / file);
    fs::create_directories(folder.path() / "empty");
    const auto found = find_masks(folder.path(), frames());
    REQUIRE(found.size() == 2);
    CHECK(found[0].name == "plant");
    REQUIRE(found[1].mask_of_frame.size() == 2);
    CHECK(found[1].mask_of_frame.at(1).filename() == "frame-000001.png");
    CHECK(found[1].mask_of_frame.at(2).filename() == "seq-02_frame-000000.jpg");
}

TEST_CASE("mask folder: pictures that are not of one frame are refused")
{
    const auto problem_of = [](std::initializer_list<const char*> files)
    {
        const testing::TemporaryFolder folder;
        for (const char* file : files)
            put(folder.path() / file);
        return fresco::testing::error_of([&] { find_masks(folder.path(), frames()); });
    };
    CHECK_THAT(problem_of({"tv/frame-000002.png"}), Contains("tv/frame-000002.png: there is no frame 'frame-000002'"));
    CHECK_THAT(problem_of({"tv/frame-000000.png"}), Contains("several sequences have a frame 'frame-000000'"));
    CHECK_THAT(problem_of({"tv/frame-000001.png", "tv/seq-01_frame-000001.png"}), Contains("are masks of the same frame"));
    CHECK_THAT(problem_of({"frame-000001.png"}), Contains("no masks; expected pictures in a folder for each region"));
}

namespace
{

constexpr int width = 40;
constexpr int height = 30;

/// A wall of 4 x 3 squares of 1 m at z = 2, which faces the camera at the origin that sees all of it, and as much behind it.
Mesh wall()
{
    Mesh mesh;
    for (const float z : {2.0F, 3.0F})
        testing::append(mesh, testing::rectangle({-2, -1.5F, z}, {0, 3, 0}, {4, 0, 0}, 3, 4));
    return mesh;
}

Frames one_frame()
{
    Frames frames;
    frames.frames.push_back(testing::frame("frame-000000", testing::camera(width, height, 20)));
    return frames;
}

void draw(const fs::path& file, int w, int h, const std::function<bool(int, int)>& inside)
{
    const Raster8 mask = testing::picture(w, h, [&](int x, int y, int) { return inside(x, y) ? 255 : 0; });
    fs::create_directories(file.parent_path());
    write_file(file, testing::RawImages().encode_png(mask));
}

std::shared_ptr<Regions> masked(const fs::path& folder, testing::TestRun& run, const Regions* base = nullptr)
{
    testing::Inputs inputs{{"mesh", std::make_shared<Mesh>(wall())}, {"frames", std::make_shared<Frames>(one_frame())}};
    if (base != nullptr)
        inputs["regions"] = std::make_shared<Regions>(*base);
    return testing::output_of<Regions>("regions.labels", "regions", Value::Map{{"masks", folder.string()}}, inputs, run,
                                       {{"image_io", std::make_shared<testing::RawImages>()}});
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest,
                 "regions.labels: faces take the region that most of their pixels are in; hidden ones take none",
                 "[regions.labels]")
{
    // The first two columns of squares are 10 pixels wide. Each mask has a bit of other columns: less than the other's, or than
    // half.
    draw(folder.path() / "window/frame-000000.png", width, height, [](int x, int) { return x < 12; });
    draw(folder.path() / "door/frame-000000.png", width, height, [](int x, int) { return x >= 8 && x < 22; });
    const auto regions = masked(folder.path(), run);
    CHECK(regions->names == std::vector<std::string>{"door", "window", "other"});
    for (std::size_t f = 0; f < regions->label_of_face.size(); ++f)
        CHECK(regions->names[regions->label_of_face[f]] == (f < 6 ? "window" : f < 12 ? "door" : "other"));
    CHECK(run.reported.at("seen_share").as_double() == Approx(0.5));
    CHECK(run.files_read.size() == 2);

    std::vector<std::uint32_t> labels(48, 1);
    labels[47] = 0;
    const Regions base = regions_from(wall(), {"floor", "walls"}, labels);
    const auto over = masked(folder.path(), run, &base);
    CHECK(over->names[over->label_of_face[0]] == "window");
    CHECK(over->names[over->label_of_face[12]] == "walls");
    CHECK(over->names[over->label_of_face[47]] == "floor");
}

TEST_CASE_METHOD(testing::StageTest, "regions.labels: masks of another size, or that mark nothing, are refused by name",
                 "[regions.labels]")
{
    const testing::TemporaryFolder small;
    draw(small.path() / "tv/frame-000000.png", width / 2, height / 2, [](int, int) { return true; });
    CHECK_THROWS_WITH(masked(small.path(), run), Contains("tv/frame-000000.png: 20 x 15 pixels"));
    const testing::TemporaryFolder black;
    draw(black.path() / "tv/frame-000000.png", width, height, [](int, int) { return false; });
    CHECK_THROWS_WITH(masked(black.path(), run), Contains("tv: no mask marks any surface of the mesh"));
    const testing::TemporaryFolder clear;
    fs::create_directories(clear.path() / "tv");
    write_file(clear.path() / "tv/frame-000000.png", testing::RawImages().encode_png(Raster8(width, height, 4, 0)));
    CHECK_THROWS_WITH(masked(clear.path(), run), Contains("tv/frame-000000.png: the mask has transparent pixels"));
    Regions other;
    other.names = {"a"};
    other.label_of_face = {0};
    CHECK_THROWS_WITH(masked(black.path(), run, &other), Contains("the regions on port 'regions' are of another mesh"));
}
