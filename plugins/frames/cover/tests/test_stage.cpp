#include "catch.h"
#include "covering.h"
#include "plugin_under_test.h"
#include "raw_images.h"
#include "shared_data.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/stage.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <array>
#include <cmath>

using namespace fresco;
using namespace fresco::cover;
using numerics::SeenCell;
namespace fs = std::filesystem;

namespace
{

std::vector<SeenCell> cells(std::initializer_list<std::pair<int, int>> list)
{
    std::vector<SeenCell> seen;
    for (const auto& [cell, worth] : list)
        seen.emplace_back(static_cast<std::uint32_t>(cell), static_cast<std::uint32_t>(worth));
    return seen;
}

/// One row of pixels, of which those with a cosine >= 0 are valid.
UvMap row_of(const std::vector<std::array<float, 3>>& pixels)
{
    const int width = static_cast<int>(pixels.size());
    UvMap map{RasterF(width, 1, 2), RasterF(width, 1), RasterF(width, 1), Raster8(width, 1)};
    for (int x = 0; x < width; ++x)
    {
        const auto& [u, v, cosine] = pixels[static_cast<std::size_t>(x)];
        if (cosine < 0)
            continue;
        map.uv.at(x, 0, 0) = u;
        map.uv.at(x, 0, 1) = v;
        map.cosine.at(x, 0) = cosine;
        map.valid.at(x, 0) = 1;
    }
    return map;
}

}  // namespace

TEST_CASE("pixels fall into cells, of which each keeps its best pixel", "[frames.cover]")
{
    // 4 x 4 cells. Two pixels in cell (1, 0), the upper right corner, and one that is not valid.
    const auto map = row_of({{0.30F, 0.1F, 0.2F}, {1, 1, 1}, {0.45F, 0.2F, 0.6F}, {0.9F, 0.1F, -1}});
    const auto seen = seen_cells(map, 4, 1, {.angle_weight = 1, .sharpness_weight = 0});
    // (1 + 0.6) / 2 and (1 + 1) / 2 of 254, plus 1.
    CHECK(seen == cells({{1, 204}, {15, 255}}));
    // Half as sharp as can be: (1 + 0.5 + 2 * 0.6) / 4.
    CHECK(seen_cells(map, 4, 0.5, {.angle_weight = 2, .sharpness_weight = 1}).front() == SeenCell(1, 172));
    CHECK(seen_cells(map, 4, 0, {.angle_weight = 0, .sharpness_weight = 0}) == cells({{1, 255}, {15, 255}}));
    CHECK(seen_cells(row_of({{0, 0, -1}}), 4, 1, {}).empty());
    CHECK(seen_cells(row_of({{1, 1, 0}}), 4096, 0, {}).front().cell() == SeenCell::most_cells - 1);
}

namespace
{

/// A wall of 4 m x 1 m at z = 1, one texel a centimeter of a texture of 4 m x 4 m, in squares of 0.1 m; it faces the cameras.
Mesh wall()
{
    Mesh mesh = testing::rectangle({0, 0, 1}, {0, 1, 0}, {4, 0, 0}, 10, 40);
    testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{p.x / 4, p.y / 4}; });
    return mesh;
}

/// A camera that sees 1 m x 1 m of the wall around (x, 0.5).
Frame looking_at(double x, const std::string& name)
{
    return testing::frame(name, testing::camera(64, 64, 64, {x, 0.5, 0}));
}

/// Four frames tile the wall, three others lie between them.
Frames tiling()
{
    Frames frames;
    for (int i = 0; i < 7; ++i)
        frames.frames.push_back(looking_at(0.5 + 0.5 * i, "frame-" + std::to_string(i)));
    return frames;
}

std::vector<std::string> covering_views(const Mesh& mesh, const Frames& frames, const CoverOptions& options,
                                        testing::TestRun& run)
{
    const testing::RawImages images;
    std::vector<std::string> names;
    for (const Frame& frame : covering_frames(mesh, frames, options, &images, run).frames)
        names.push_back(frame.name);
    return names;
}

constexpr CoverOptions plain{.target_coverage = 1,
                             .min_seen_share = 0,
                             .cells_px = 40,
                             .height_px = 64,
                             .worth = {.angle_weight = 0, .sharpness_weight = 0}};

template <class Change>
CoverOptions with(const Change& change)
{
    CoverOptions options = plain;
    change(options);
    return options;
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "the frames that tile a wall are chosen, those between them are not", "[frames.cover]")
{
    CHECK(covering_views(wall(), tiling(), plain, run) == std::vector<std::string>{"frame-0", "frame-2", "frame-4", "frame-6"});
    CHECK(run.reported.at("cells").as_int() == 400);
    CHECK(run.reported.at("blind_frames").as_int() == 0);
    CHECK_THAT(run.messages.at(0), Contains("4 of 7 frames see 100.0 % of what all see"));
}

TEST_CASE_METHOD(testing::StageTest, "a target, a number and a share end the choice", "[frames.cover]")
{
    CHECK(covering_views(wall(), tiling(), with([](auto& o) { o.target_coverage = 0.5; }), run).size() == 2);
    CHECK(run.reported.at("coverage").as_double() == 0.5);
    CHECK(covering_views(wall(), tiling(), with([](auto& o) { o.max_frames = 3; }), run).size() == 3);
    CHECK(covering_views(wall(), tiling(), with([](auto& o) { o.max_share = 2 / 7.0; }), run).size() == 2);
    CHECK(covering_views(wall(), tiling(), with([](auto& o) { o.max_share = 0.01; }), run).size() == 1);
    // Two thirds of six frames, of which three stand in one place: evenly spread ones leave a quarter of the wall out.
    Frames crowded;
    for (const auto& [x, name] : {std::pair(0.5, "a"), {0.5, "b"}, {0.5, "c"}, {1.5, "d"}, {2.5, "e"}, {3.5, "f"}})
        crowded.frames.push_back(looking_at(x, name));
    CHECK(covering_views(wall(), crowded, plain, run) == std::vector<std::string>{"a", "d", "e", "f"});
    const auto& rows = run.reported.at("coverage_by_frames").as_list();
    CHECK(rows.back().at("frames").as_int() == 4);
    CHECK(rows.back().at("coverage").as_double() == 1);
    CHECK(rows.back().at("evenly_spread").as_double() == 0.75);
    CHECK(rows.front().at("frames").as_int() == 1);
}

TEST_CASE_METHOD(testing::StageTest, "of frames that see the same the sharp and the straight ones are chosen", "[frames.cover]")
{
    Frames frames;
    for (const char* name : {"blurred", "sharp"})
    {
        frames.frames.push_back(looking_at(2, name));
        Raster8 picture(64, 64, 3, 100);
        for (std::size_t i = 0; i < picture.values.size(); i += 2)
            picture.values[i] = std::string(name) == "sharp" ? 200 : 110;
        testing::set_color_picture(frames.frames.back(), folder.path(), picture);
    }
    CHECK(covering_views(wall(), frames, plain, run) == std::vector<std::string>{"blurred"});
    CoverOptions options = with([](auto& o) { o.worth.sharpness_weight = 1; });
    CHECK(covering_views(wall(), frames, options, run) == std::vector<std::string>{"sharp"});

    // Both see all of the wall, one at 45°.
    Frames both;
    both.frames = {looking_at(2, "aslant"), looking_at(2, "straight")};
    const double c = std::sqrt(0.5);
    both.frames[0].color.world_from_camera = {{{c, 0, c, 0, 1, 0, -c, 0, c}}, {-4, 0.5, -5}};
    both.frames[1].color.world_from_camera.translation.z = -5;
    options = with([](auto& o) { o.height_px = 256; });
    CHECK(covering_views(wall(), both, options, run) == std::vector<std::string>{"aslant"});
    CHECK(run.reported.at("cells").as_int() == 400);
    options.worth.angle_weight = 1;
    options.max_frames = 1;
    CHECK(covering_views(wall(), both, options, run) == std::vector<std::string>{"straight"});
}

TEST_CASE_METHOD(testing::StageTest, "frames that see little of the mesh are not chosen, nor what a mask ignores",
                 "[frames.cover]")
{
    // The last frame sees the wall's end, 0.1 m of it on a picture of 1 m.
    Frames frames = tiling();
    frames.frames.push_back(looking_at(4.4, "end"));
    frames.frames.erase(frames.frames.begin() + 6);
    const CoverOptions options = with([](auto& o) { o.min_seen_share = 0.2; });
    CHECK(covering_views(wall(), frames, options, run) == std::vector<std::string>{"frame-0", "frame-2", "frame-4", "frame-5"});
    CHECK(run.reported.at("cells").as_int() == 350);
    CHECK(run.reported.at("blind_frames").as_int() == 1);
    CHECK(covering_views(wall(), frames, plain, run).back() == "end");

    Raster8 mask(64, 64, 1, 255);
    std::fill_n(mask.values.begin(), 64 * 32, std::uint8_t{0});
    write_npy(folder.path() / "mask.npy", mask);
    for (auto& frame : frames.frames)
        frame.mask = {folder.path() / "mask.npy", ""};
    covering_views(wall(), frames, options, run);
    CHECK(run.reported.at("cells").as_int() == 175);
}

TEST_CASE_METHOD(testing::StageTest, "what cannot be covered is refused", "[frames.cover]")
{
    CHECK_THROWS_WITH(covering_views(wall(), Frames(), plain, run), Contains("no frames"));
    auto bare = wall();
    bare.texcoords.clear();
    CHECK_THROWS_WITH(covering_views(bare, tiling(), plain, run), Contains("atlas.*"));
    auto away = tiling();
    for (auto& frame : away.frames)
        frame.color.world_from_camera.translation.z = 3;
    CHECK_THROWS_WITH(covering_views(wall(), away, plain, run), Contains("none of the 7 frames"));
}
