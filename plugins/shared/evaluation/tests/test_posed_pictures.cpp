#include "catch.h"

#include <fresco/evaluation/posed_pictures.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

using namespace fresco;
using namespace fresco::evaluation;

namespace
{
Frames three_frames()
{
    Frames frames;
    for (const char* name : {"b", "a", "c"})
    {
        frames.frames.push_back(testing::frame(name, testing::camera(40, 30, 20)));
        frames.frames.back().sequence = "seq_01";
    }
    return frames;
}
}  // namespace

TEST_CASE("pictures are found by their frames' names, in the frames' order")
{
    testing::TemporaryFolder folder;
    testing::TestRun run;
    for (const char* name : {"seq_01_a.png", "seq_01_b.jpg", "seq_01_d.png", "seq_01_c.txt"})
        write_file(folder.path() / name, "x");
    const auto found = posed_pictures(three_frames(), nullptr, folder.path(), run);
    REQUIRE(found.size() == 2);
    CHECK(found[0].frame == 0);
    CHECK(found[0].file.filename() == "seq_01_b.jpg");
    CHECK(found[1].frame == 1);
    CHECK(run.folders_read ==
          std::vector<std::filesystem::path>{folder.path() / "*.png", folder.path() / "*.jpg", folder.path() / "*.jpeg"});
    CHECK(run.files_read.size() == 2);

    write_file(folder.path() / "seq_01_c.npy", "x");
    CHECK(posed_pictures(three_frames(), nullptr, folder.path(), run).size() == 2);
    CHECK(posed_pictures(three_frames(), nullptr, folder.path(), run, picture_or_npy).back().file.filename() == "seq_01_c.npy");
    CHECK(run.folders_read.back() == folder.path() / "*.npy");

    Files views;
    views.names = {"views/seq_01_c.png"};
    views.loaded_from = "/somewhere";
    const auto listed = posed_pictures(three_frames(), &views, {}, run);
    REQUIRE(listed.size() == 1);
    CHECK(listed[0].frame == 2);
    CHECK(listed[0].file == "/somewhere/views/seq_01_c.png");

    write_file(folder.path() / "seq_01_a.jpeg", "x");
    CHECK_THROWS_WITH(posed_pictures(three_frames(), nullptr, folder.path(), run), Catch::Contains("same view"));
}

TEST_CASE("pictures of nothing are refused")
{
    testing::TemporaryFolder folder;
    testing::TestRun run;
    write_file(folder.path() / "0001.png", "x");
    CHECK_THROWS_WITH(posed_pictures(three_frames(), nullptr, folder.path(), run), Catch::Contains("seq_01_a.png"));
    CHECK_THROWS_WITH(posed_pictures(three_frames(), nullptr, {}, run), Catch::Contains("either port 'views'"));
    const Files views;
    CHECK_THROWS_WITH(posed_pictures(three_frames(), &views, folder.path(), run), Catch::Contains("either port 'views'"));
    Frames twice = three_frames();
    twice.frames[2].name = "b";
    write_file(folder.path() / "seq_01_b.png", "x");
    CHECK_THROWS_WITH(posed_pictures(twice, nullptr, folder.path(), run), Catch::Contains("two frames are named seq_01_b"));
}
