#include "catch.h"
#include "masks.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <map>

using namespace fresco;
using raycast::Hit;

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

TEST_CASE("votes: a pixel is in the mask where it is bright in the mean")
{
    Raster8 mask(2, 1, 3);
    mask.values = {255, 255, 0, 255, 0, 0};
    CHECK(is_in_mask(mask, 0, 0));
    CHECK(!is_in_mask(mask, 1, 0));
}

TEST_CASE("votes: the winner is what counting pixel by pixel says")
{
    Random random(2);
    constexpr std::size_t faces = 40, regions = 3;
    constexpr int side = 20;
    Votes votes(regions, faces);
    std::map<std::pair<std::size_t, std::uint32_t>, std::pair<double, double>> counts;
    for (int picture = 0; picture < 5; ++picture)
    {
        std::vector<std::uint32_t> seen(side * side);
        for (std::uint32_t& face : seen)
        {
            face = static_cast<std::uint32_t>(random.uniform() * 50);
            face = face >= faces ? Hit::none : face;
        }
        const auto region = static_cast<std::size_t>(random.uniform() * regions);
        Raster8 mask(side, side, 1);
        for (std::uint8_t& value : mask.values)
            value = random.uniform() < 0.5 ? 255 : 0;
        votes.add(region, mask, seen);
        for (std::size_t i = 0; i < seen.size(); ++i)
            if (seen[i] != Hit::none)
            {
                counts[{region, seen[i]}].first += mask.values[i] != 0 ? 1 : 0;
                counts[{region, seen[i]}].second += 1;
            }
    }
    for (const double least : {0.2, 0.5, 0.6})
    {
        const auto winners = votes.winners(least);
        for (std::uint32_t face = 0; face < faces; ++face)
        {
            std::uint32_t expected = regions;
            double best = 0;
            bool is_seen = false;
            for (std::uint32_t region = 0; region < regions; ++region)
                if (const auto count = counts.find({region, face}); count != counts.end())
                {
                    is_seen = true;
                    const double share = count->second.first / count->second.second;
                    if (share >= least && share > best)
                    {
                        best = share;
                        expected = region;
                    }
                }
            CHECK(winners[face] == expected);
            CHECK(votes.is_seen(face) == is_seen);
        }
    }
}
