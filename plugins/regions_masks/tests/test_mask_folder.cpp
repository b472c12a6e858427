#include "catch.h"
#include "mask_folder.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

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

TEST_CASE("mask folder: a folder for each region, a picture for each frame")
{
    const testing::TemporaryFolder folder;
    put(folder.path() / "tv/frame-000001.png");
    put(folder.path() / "tv/seq-02_frame-000000.jpg");
    put(folder.path() / "tv/.hidden.png");
    put(folder.path() / "tv/notes.txt");
    put(folder.path() / "plant/seq-01_frame-000000.png");
    put(folder.path() / "readme.png");
    fs::create_directories(folder.path() / "empty");
    const auto found = find_masks(folder.path(), frames());
    REQUIRE(found.size() == 2);
    CHECK(found[0].name == "plant");
    REQUIRE(found[1].masks.size() == 2);
    CHECK(found[1].masks[0].frame == 1);
    CHECK(found[1].masks[1].frame == 2);
    CHECK(found[1].masks[1].file.filename() == "seq-02_frame-000000.jpg");
}

TEST_CASE("mask folder: pictures that are not of one frame are refused")
{
    const auto problem_of = [](std::initializer_list<const char*> files)
    {
        const testing::TemporaryFolder folder;
        for (const char* file : files)
            put(folder.path() / file);
        try
        {
            find_masks(folder.path(), frames());
        }
        catch (const Error& error)
        {
            return std::string(error.what());
        }
        return std::string();
    };
    CHECK_THAT(problem_of({"tv/frame-000002.png"}), Catch::Contains("tv/frame-000002.png: there is no frame 'frame-000002'") &&
                                                        Catch::Contains("name masks after the frames"));
    CHECK_THAT(problem_of({"tv/frame-000000.png"}), Catch::Contains("several sequences have a frame 'frame-000000'"));
    CHECK_THAT(problem_of({"tv/frame-000001.png", "tv/seq-01_frame-000001.png"}), Catch::Contains("are masks of the same frame"));
    CHECK_THAT(problem_of({"frame-000001.png"}), Catch::Contains("no masks; expected pictures in a folder for each region"));
}
