#include "catch.h"
#include "plugin_under_test.h"
#include "view_cases.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/npy.h>
#include <fresco/testing.h>
#include <fresco/uv_maps.h>

#include <cmath>

namespace
{
using namespace fresco;

std::shared_ptr<Mesh> shared_wall()
{
    return std::make_shared<Mesh>(cases::wall());
}

/// One frame before the wall, one that looks away; the depth cameras differ from the color cameras.
std::shared_ptr<Frames> two_frames()
{
    auto frames = std::make_shared<Frames>();
    for (const char* name : {"frame-000000", "frame-000001"})
    {
        Frame frame = testing::frame(name, testing::camera(64, 48, 50));
        frame.depth = testing::camera(32, 24, 40, {0.5, 0.5, 0});
        frames->frames.push_back(frame);
    }
    frames->frames[1].color.world_from_camera.translation = {0, 0, 5};
    return frames;
}

/// The maps that the stage makes, below `folder`.
std::shared_ptr<UvMaps> maps_of(const Value& options, const std::shared_ptr<Mesh>& mesh, const std::shared_ptr<Frames>& frames,
                                const std::filesystem::path& folder, testing::TestRun& run)
{
    testing::run_stage(FRESCO_PLUGIN_FILE, "uvmaps.raster", options, {{"mesh", mesh}, {"frames", frames}}, folder, run);
    return UvMaps::load({folder / "uvmaps", folder});
}

void refused(const Value& options, const std::shared_ptr<Mesh>& mesh, const std::shared_ptr<Frames>& frames, const char* reason)
{
    testing::TemporaryFolder folder;
    testing::TestRun run;
    CHECK_THROWS_WITH(maps_of(options, mesh, frames, folder.path(), run), Catch::Contains(reason));
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "the stage streams a map per frame and height and counts what it saw")
{
    const auto maps = maps_of(Value::Map{{"heights_px", Value::List{24, 16}}}, shared_wall(), two_frames(), folder.path(), run);
    CHECK(maps->heights_px == std::vector<int>{16, 24});
    REQUIRE(maps->views.size() == 2);
    CHECK(maps->views[0].sequence + "/" + maps->views[0].frame == "seq-01/frame-000000");
    CHECK(maps->views[0].camera == two_frames()->frames[0].color);
    CHECK(maps->views[0].valid_pixels == std::vector<std::int64_t>{336, 768});
    CHECK(maps->views[1].valid_pixels == std::vector<std::int64_t>{0, 0});
    const UvMap map = maps->load_map(0, 1);
    CHECK(map.uv.width == 32);
    CHECK(map.depth.at(31, 23) == Approx(2).epsilon(1e-3));
    constexpr int half = 21 * 16 + 32 * 24;
    for (const auto& [key, value] : {std::pair{"blind_frames", 1}, {"maps", 4}, {"valid_pixels", half}, {"empty_pixels", half}})
        CHECK(run.reported.at(key).as_int() == value);
    REQUIRE(run.messages.size() == 1);
    CHECK(run.messages[0].find("1 of 2 frames") != std::string::npos);
}

TEST_CASE("frames that an interrupted run had finished are not looked at again, and the maps are the same")
{
    const Value options = Value::Map{{"heights_px", Value::List{16, 24}}};
    testing::TemporaryFolder whole, pieces;
    testing::TestRun once(1), run(1);
    maps_of(options, shared_wall(), two_frames(), whole.path(), once);
    // Stopped later and later, until what was kept is enough to come to the end.
    int checks = 1;
    const auto is_stopped = [&]
    {
        run.cancel_after(checks);
        try
        {
            maps_of(options, shared_wall(), two_frames(), pieces.path(), run);
            return false;
        }
        catch (const Canceled&)
        {
            return true;
        }
    };
    while (is_stopped())
        REQUIRE(++checks < 1000);
    REQUIRE(run.messages.size() == 2);
    CHECK(run.messages[0] == "the maps of 1 of 2 frames were there from an interrupted run");
    CHECK(run.messages[1] == once.messages[0]);
    CHECK(run.reported == once.reported);
    for (const auto& entry : std::filesystem::directory_iterator(whole.path() / "uvmaps"))
        CHECK(read_file(entry.path()) == read_file(pieces.path() / "uvmaps" / entry.path().filename()));
}

TEST_CASE_METHOD(testing::StageTest, "pixels that a mask ignores are not seen, at any height")
{
    const auto frames = two_frames();
    // The left quarter of 64 x 48 and one pixel right of it.
    Raster8 mask(64, 48, 1, 255);
    for (std::size_t i = 0; i < mask.values.size(); ++i)
        if (i % 64 < 16 || i == 47 * 64 + 63)
            mask.values[i] = 0;
    frames->frames[0].mask = {folder.path() / "mask.npy", ""};
    write_npy(frames->frames[0].mask.path, mask);
    const auto maps = maps_of(Value::Map{{"heights_px", Value::List{24, 96}}}, shared_wall(), frames, folder.path(), run);
    CHECK(maps->views[0].valid_pixels == std::vector<std::int64_t>{24 * 24 - 1, 96 * 96 - 4});
    CHECK(run.reported.at("masked_pixels").as_int() == 24 * 8 + 1 + 96 * 32 + 4);
    const UvMap map = maps->load_map(0, 0);
    CHECK(map.valid.at(7, 5) == 0);
    CHECK(map.depth.at(7, 5) == 0);
    CHECK(map.valid.at(8, 5) == 1);
    CHECK(map.valid.at(31, 23) == 0);
    frames->frames[0].color.intrinsics.width = 63;
    refused(Value::Map{}, shared_wall(), frames, "mask.npy: is 64x48");
}

TEST_CASE("angles are those of the vertices' normals or of the faces'")
{
    // A roof across the picture: its two faces lean by 45 degrees, the normal of their ridge not at all.
    const auto roof = std::make_shared<Mesh>();
    roof->positions = {{0, -9, 2}, {0, 9, 2}, {5, 0, 7}, {-5, 0, 7}};
    roof->triangles = {{0, 1, 2}, {1, 0, 3}};
    roof->texcoords = {{0.1F, 0.1F}, {0.1F, 0.9F}, {0.4F, 0.5F}, {0.9F, 0.9F}, {0.9F, 0.1F}, {0.6F, 0.5F}};
    const auto cosine = [&](const char* normals)
    {
        testing::TemporaryFolder folder;
        testing::TestRun run;
        const Value options = Value::Map{{"heights_px", Value::List{48}}, {"normals", normals}};
        const UvMap map = maps_of(options, roof, two_frames(), folder.path(), run)->load_map(0, 0);
        REQUIRE(map.valid.at(32, 24) == 1);
        return map.cosine.at(32, 24);
    };
    CHECK(cosine("smooth") == Approx(1).margin(0.02));
    CHECK(cosine("face") == Approx(std::sqrt(0.5)).margin(0.02));
}

TEST_CASE("what the stage cannot use is refused with the way out")
{
    auto bare = shared_wall();
    bare->texcoords.clear();
    refused(Value::Map{}, bare, two_frames(), "wire an atlas.* stage");
    auto repeating = shared_wall();
    repeating->texcoords[4].y = 1.5F;
    refused(Value::Map{}, repeating, two_frames(), "face 1 of the mesh on port 'mesh' has texcoords outside [0,1]");
    refused(Value::Map{}, shared_wall(), std::make_shared<Frames>(), "no frames");
    auto folded = shared_wall();
    testing::append(*folded, testing::wall(2, 5));
    refused(Value::Map{}, folded, two_frames(), "the mesh on port 'mesh' lies on other parts in the atlas");
    auto twisted = two_frames();
    twisted->frames[1].color.world_from_camera.rotation(0, 0) = 2;
    refused(Value::Map{}, shared_wall(), twisted, "seq-01/frame-000001");
    for (const auto& [heights, reason] :
         {std::pair{Value::List{32, 32}, "32 twice"}, {{}, "empty"}, {Value::List{8}, "heights_px"}})
        refused(Value::Map{{"heights_px", heights}}, shared_wall(), two_frames(), reason);
}
