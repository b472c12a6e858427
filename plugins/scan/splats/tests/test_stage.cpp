#include "catch.h"
#include "raw_images.h"
#include "shared_data.h"
#include "splat_samples.h"
#include "splat_scenes.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/testing.h>

#include <algorithm>

using namespace splat_scenes;
using testing::RawImages;

namespace
{

struct Scanned
{
    testing::TestRun run;
    testing::TemporaryFolder folder;
    std::shared_ptr<Frames> frames;

    explicit Scanned(int threads = 2) : run(threads) {}

    void read(const Splats& splats, Value::Map options = {})
    {
        const auto file = folder.path() / "scene.ply";
        write_file(file, splats::samples::ply(splats));
        options.emplace_back("path", file.string());
        testing::run_stage(FRESCO_PLUGIN_FILE, "scan.splats", options, {}, folder.path() / "out", run,
                           {{"image_io", std::make_shared<RawImages>()}});
        frames = Frames::load({folder.path() / "out" / "frames", {}});
    }

    bool said(const std::string& text) const
    {
        return std::ranges::any_of(run.messages, [&](const std::string& message) { return message.find(text) != message.npos; });
    }
};

}  // namespace

TEST_CASE("views of a splat have color, depth and a mask of what is seen", "[scan.splats]")
{
    Scanned scanned;
    scanned.read(statue(), {{"up", "z"}});
    REQUIRE(scanned.frames->frames.size() >= 8);
    CHECK(scanned.said("around an object"));
    CHECK(scanned.said("warning: PLY files have no unit: in meters, the scene measures 0.6"));
    const RawImages images;
    std::size_t hits = 0;
    for (const Frame& frame : scanned.frames->frames)
    {
        const Raster8 color = load_color(frame, &images), mask = load_mask(frame);
        const RasterF depth = load_depth(frame, &images);
        for (int y = 0; y < depth.height; ++y)
            for (int x = 0; x < depth.width; ++x)
            {
                const double z = static_cast<double>(depth.at(x, y));
                if ((z > 0) != (mask.at(x, y) == 255))
                    FAIL("mask and depth differ at " << x << ", " << y);
                if (z == 0)
                    continue;
                ++hits;
                const Vec3d point = frame.depth.world_from_camera.translation + frame.depth.ray(x + 0.5, y + 0.5) * z;
                // On the ball, the pole or the disk.
                const double apart =
                    std::min({std::abs(length(point - Vec3d{0, 0, 0.3}) - 0.1), std::abs(point.z),
                              std::abs(std::max(std::abs(point.x), std::abs(point.y)) - 0.02), std::abs(point.z - 0.2)});
                if (apart > 0.02)
                    FAIL("a depth lies " << apart << " m from the surface");
                if (std::abs(color.at(x, y, 0) - 127) > 2 || std::abs(color.at(x, y, 2) - 76) > 2)
                    FAIL("the color is not the splats'");
            }
    }
    CHECK(hits > 100'000);
}

TEST_CASE("a splat far from 0 and in other units is the same scene less an offset", "[scan.splats]")
{
    Splats moved = room();
    for (Vec3f& center : moved.centers)
        center = center * 10 + Vec3f{400'000, 0, 0};
    for (Vec3f& scale : moved.scales)
        scale = scale * 10;
    Scanned scanned;
    scanned.read(moved, {{"unit_m", 0.1}, {"up", "z"}});
    CHECK(scanned.frames->offset_m == Vec3d{40'000, 0, 0});
    CHECK(scanned.said("inside a room"));
    CHECK_FALSE(scanned.said("no unit"));
    for (const Frame& frame : scanned.frames->frames)
        CHECK((frame.color.world_from_camera.translation.x > 0 && frame.color.world_from_camera.translation.x < 4));
}

TEST_CASE("the way up is asked for where nothing shows it, and guessed by what is near the floor", "[scan.splats]")
{
    const bool is_upside_down = GENERATE(false, true);
    Splats ball = statue();
    if (is_upside_down)
        for (Vec3f& center : ball.centers)
            center = {center.x, -center.y, -center.z};
    Scanned scanned;
    scanned.read(ball);
    CHECK(scanned.said(is_upside_down ? "so -z is taken; if it comes out lying or upside down, set up" : "so z is taken"));
    for (const Frame& frame : scanned.frames->frames)
        CHECK(frame.color.world_from_camera.rotation(2, 1) * (is_upside_down ? -1 : 1) <= 1e-9);
}

TEST_CASE("scans are the same for any number of threads", "[scan.splats]")
{
    Scanned one(1), four(4);
    one.read(statue());
    four.read(statue());
    REQUIRE(one.frames->frames.size() == four.frames->frames.size());
    for (std::size_t i = 0; i < one.frames->frames.size(); ++i)
    {
        CHECK(one.frames->frames[i].color == four.frames->frames[i].color);
        CHECK(read_file(one.frames->frames[i].depth_picture.path) == read_file(four.frames->frames[i].depth_picture.path));
        CHECK(read_file(one.frames->frames[i].color_picture.path) == read_file(four.frames->frames[i].color_picture.path));
    }
}

TEST_CASE("half-trained and invisible splats are not painted over", "[scan.splats]")
{
    Splats streaks = statue();
    for (Vec3f& scale : streaks.scales)
        scale = {scale.x * 5, scale.x / 2, scale.z};
    Scanned half_trained;
    CHECK_THROWS_WITH(half_trained.read(streaks),
                      Catch::Contains("100 % of what is seen are streaks") && Catch::Contains("Train it to the end"));
    Splats blobs = statue();
    for (Vec3f& scale : blobs.scales)
        scale = scale * 10;
    Scanned coarse;
    CHECK_THROWS_WITH(coarse.read(blobs), Catch::Contains("% of the scene's radius") && Catch::Contains("no surface to paint"));
    const auto label = shared_data("splats/supersplat_mixed_drops_inria_sh3.ply", "the refusal of a half-trained label");
    if (!label.empty())
        CHECK_THROWS_WITH(coarse.read(splats::read_splats(label).splats), Catch::Contains("no surface to paint"));
    Splats ghost = statue();
    std::ranges::fill(ghost.opacities, 0.01F);
    Scanned invisible;
    CHECK_THROWS_WITH(invisible.read(ghost), Catch::Contains("Gaussians shows a surface: 9"));
    Splats far = room();
    for (Vec3f& center : far.centers)
        center = center * 10;
    Scanned wrong_unit;
    CHECK_THROWS_WITH(wrong_unit.read(far, {{"unit_m", 1e6}}),
                      Catch::Contains("expected at most 1e+07 m") || Catch::Contains("expected at most 10000000"));
}
