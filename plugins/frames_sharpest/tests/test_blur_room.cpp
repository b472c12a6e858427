#include "blur.h"
#include "catch.h"
#include "shared_data.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>
#include <fresco/random.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numbers>

/// \file Known motion blur in a generated room. By hand, for other sizes: FRESCO_BLUR_ROOM="640 480 240" test_frames_sharpest
/// "[room]"

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

/// The mean along a line of `length_px`, then the sensor's noise and steps.
Raster8 blurred(const Raster8& sharp, double length_px, double angle, Random& random)
{
    constexpr int samples = 12;
    constexpr double noise = 1.5;
    Raster8 result(sharp.width, sharp.height, 3);
    const auto at = [&](double x, double y, int c)
    {
        x = std::clamp(x, 0.0, sharp.width - 1.001);
        y = std::clamp(y, 0.0, sharp.height - 1.001);
        const int left = static_cast<int>(x);
        const int top = static_cast<int>(y);
        const double u = x - left;
        const double v = y - top;
        return (1 - v) * ((1 - u) * sharp.at(left, top, c) + u * sharp.at(left + 1, top, c)) +
               v * ((1 - u) * sharp.at(left, top + 1, c) + u * sharp.at(left + 1, top + 1, c));
    };
    for (int y = 0; y < sharp.height; ++y)
        for (int x = 0; x < sharp.width; ++x)
            for (int c = 0; c < 3; ++c)
            {
                double sum = 0;
                const int count = length_px > 0 ? samples : 1;
                for (int i = 0; i < count; ++i)
                {
                    const double along = length_px * ((i + 0.5) / count - 0.5);
                    sum += at(x + along * std::cos(angle), y + along * std::sin(angle), c);
                }
                result.at(x, y, c) =
                    static_cast<std::uint8_t>(std::clamp(std::lround(sum / count + noise * random.normal()), 0L, 255L));
            }
    return result;
}

/// Bursts of one to four blurred frames, as hands shake: about a quarter of all.
std::vector<double> motion(std::size_t count, Random& random)
{
    std::vector<double> lengths;
    while (lengths.size() < count)
    {
        const auto sharp = static_cast<int>(2 + 7 * random.uniform());
        for (int i = 0; i < sharp; ++i)
            lengths.push_back(0.5 * random.uniform());
        const auto shaken = static_cast<int>(1 + 4 * random.uniform());
        for (int i = 0; i < shaken; ++i)
            lengths.push_back(3 + 7 * random.uniform());
    }
    lengths.resize(count);
    return lengths;
}

/// How many points of a frame's depth picture no frame of `among` shows, judged only by depth pictures.
double unseen_share(const Frames& frames, std::size_t of, const std::vector<RasterF>& depths, const std::vector<bool>& among)
{
    const Frame& frame = frames.frames[of];
    std::size_t points = 0;
    std::size_t unseen = 0;
    for (int y = 4; y < depths[of].height; y += 8)
        for (int x = 4; x < depths[of].width; x += 8)
        {
            const double z = static_cast<double>(depths[of].at(x, y));
            if (!(z > 0))
                continue;
            const Vec3d world = frame.depth.world_from_camera.translation + frame.depth.ray(x + 0.5, y + 0.5) * z;
            ++points;
            bool is_seen = false;
            for (std::size_t other = 0; other < depths.size() && !is_seen; ++other)
            {
                const Vec3d pixel = frames.frames[other].depth.project(world);
                const Vec3d in_color = frames.frames[other].color.project(world);
                const Intrinsics& color = frames.frames[other].color.intrinsics;
                if (!among[other] || !(pixel.z > 0) ||
                    !(in_color.x >= 0 && in_color.y >= 0 && in_color.x < color.width && in_color.y < color.height))
                    continue;
                const int column = static_cast<int>(std::floor(pixel.x));
                const int row = static_cast<int>(std::floor(pixel.y));
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx)
                        if (column + dx >= 0 && row + dy >= 0 && column + dx < depths[other].width &&
                            row + dy < depths[other].height)
                            is_seen = is_seen || std::abs(static_cast<double>(depths[other].at(column + dx, row + dy)) -
                                                          pixel.z) < 0.03 + 0.05 * pixel.z;
            }
            unseen += !is_seen;
        }
    return points > 0 ? static_cast<double>(unseen) / static_cast<double>(points) : 0;
}

}  // namespace

TEST_CASE("frames blurred by motion are dropped, sharp ones and lone sights of a surface stay", "[frames.sharpest][room]")
{
    const fs::path plugins = fs::path(FRESCO_PLUGIN_FILE).parent_path();
    if (!fs::exists(plugins / "image_opencv.so") || !fs::exists(plugins / "scan_synthetic_room.so"))
    {
        skipped("frames.sharpest in a generated room: image_opencv or scan_synthetic_room is not built");
        return;
    }
    int width = 256, height = 192, count = 144;
    if (const char* sizes = std::getenv("FRESCO_BLUR_ROOM"))
        REQUIRE(std::sscanf(sizes, "%d %d %d", &width, &height, &count) == 3);
    const std::shared_ptr<ImageIo> images = testing::make_from_plugin<ImageIo>(plugins / "image_opencv.so", "image.opencv");
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    testing::run_stage(plugins / "scan_synthetic_room.so", "scan.synthetic_room",
                       Value::Map{{"frames_count", count},
                                  {"color_width_px", width},
                                  {"color_height_px", height},
                                  {"depth_width_px", 160},
                                  {"depth_height_px", 120},
                                  {"edge_m", 0.15}},
                       {}, folder.path(), run, {{"images", images}});
    Frames frames = *Frames::load({folder.path() / "frames", folder.path()});
    Random random(11);
    const std::vector<double> lengths = motion(frames.frames.size(), random);
    std::vector<RasterF> depths;
    for (std::size_t i = 0; i < lengths.size(); ++i)
    {
        Frame& frame = frames.frames[i];
        depths.push_back(load_depth(frame, images.get()));
        const Raster8 picture = blurred(load_color(frame, images.get()), lengths[i], std::numbers::pi * random.uniform(), random);
        frame.color_picture = {folder.path() / (frame.name + ".npy"), ""};
        write_npy(frame.color_picture.path,
                  std::vector<std::size_t>{static_cast<std::size_t>(height), static_cast<std::size_t>(width), 3},
                  std::span<const std::uint8_t>(picture.values));
    }

    testing::run_stage(FRESCO_PLUGIN_FILE, "frames.sharpest", Value::Map{}, {{"frames", std::make_shared<Frames>(frames)}},
                       folder.path() / "out", run, {{"images", images}});
    const Value& judged = run.reported.at("judged_frames");
    std::size_t blurred_count = 0, blurred_dropped = 0, sharp_count = 0, sharp_dropped = 0, needed = 0;
    std::vector<bool> is_kept;
    for (std::size_t i = 0; i < lengths.size(); ++i)
    {
        const bool kept = judged.at("kept").as_list()[i].as_bool();
        const double found = judged.at("values").as_list()[i].as_double();
        is_kept.push_back(kept);
        if (std::getenv("FRESCO_BLUR_ROOM"))
            std::cout << frames.frames[i].name << " " << lengths[i] << " found " << found << (kept ? "" : " dropped") << "\n";
        if (lengths[i] < 0.5)
        {
            ++sharp_count;
            sharp_dropped += !kept;
        }
        else if (kept && found > judged.at("most").as_double())
            ++needed;
        else
        {
            ++blurred_count;
            blurred_dropped += !kept;
        }
    }
    std::cout << blurred_dropped << " of " << blurred_count << " blurred and " << sharp_dropped << " of " << sharp_count
              << " sharp frames dropped, " << needed << " kept although blurred\n";
    CHECK(static_cast<double>(blurred_dropped) >= 0.95 * static_cast<double>(blurred_count));
    CHECK(static_cast<double>(sharp_dropped) <= 0.02 * static_cast<double>(sharp_count));
    double lost = 0;
    for (std::size_t i = 0; i < lengths.size(); ++i)
        if (!is_kept[i])
            lost = std::max(lost, unseen_share(frames, i, depths, is_kept));
    std::cout << "largest share of a dropped picture that no kept one shows: " << lost << "\n";
    CHECK(lost < 0.02);
}
