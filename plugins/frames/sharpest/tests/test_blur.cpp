#include "blur.h"
#include "catch.h"
#include "plugin_under_test.h"
#include "raw_images.h"

#include <fresco/frames.h>
#include <fresco/random.h>
#include <fresco/stage.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <cmath>

using namespace fresco;
using namespace sharpest;

namespace
{

constexpr int width = 160;
constexpr int height = 120;

/// Dark and light tiles of many sizes over `textured` of the width; even gray beyond. Noise everywhere, after a blur along x.
Raster8 picture_of(double textured, int blur_steps, std::uint64_t seed, double exposure = 1)
{
    const auto tile = [&](int x, int y)
    {
        Random at(static_cast<std::uint64_t>(1000 * ((x + 50) / 5) + (y / 7) % 1000));
        return x < textured * width ? 40 + 170 * at.uniform() : 128.0;
    };
    Random random(seed);
    Raster8 result(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            double sum = 0;
            for (int i = 0; i < blur_steps; ++i)
                sum += tile(x + i - blur_steps / 2, y);
            const double gray = exposure * sum / blur_steps + random.normal();
            for (int c = 0; c < 3; ++c)
                result.at(x, y, c) = static_cast<std::uint8_t>(std::clamp(std::lround(gray), 0L, 255L));
        }
    return result;
}

/// A wall at 2 m, seen from `x_m`.
BlurView view_of(const Raster8& picture, double x_m)
{
    const Camera camera = testing::camera(width, height, 120, {x_m, 0, 0});
    BlurView view{"walk", detail_of(picture), {}};
    view.surface =
        SeenSurface(RasterF(width / 2, height / 2, 1, 2),
                    {camera.intrinsics.scaled_to(width / 2, height / 2), camera.world_from_camera}, camera, view.detail);
    return view;
}

}  // namespace

TEST_CASE("the change at a lag is that of the picture blurred as far, written out")
{
    const Raster8 picture = picture_of(1, 1, 3);
    const Detail detail = detail_of(picture);
    REQUIRE(detail.blocks.size() == 70);
    const auto gray = [&](int x, int y) { return static_cast<double>(picture.at(x, y, 0)); };
    const int left = 3 * block_px, top = 2 * block_px;
    const BlockDetail& block = detail.blocks[2 * 10 + 3];
    for (std::size_t k = 0; k < lags.size(); ++k)
    {
        double right = 0, up_left = 0;
        for (int y = top; y < top + block_px; ++y)
            for (int x = left; x < left + block_px; ++x)
            {
                const auto mean_right = [&](int from)
                {
                    double sum = 0;
                    for (int i = 0; i < lags[k]; ++i)
                        sum += gray(from + i, y);
                    return sum / lags[k];
                };
                right += std::pow(mean_right(x + 1) - mean_right(x), 2) / (block_px * block_px);
                up_left += std::pow((gray(x - lags[k], y + lags[k]) - gray(x, y)) / lags[k], 2) / (block_px * block_px);
            }
        CHECK(static_cast<double>(block.change[0][k]) / (lags[k] * lags[k]) == Approx(right).epsilon(0.01));
        CHECK(static_cast<double>(block.change[3][k]) / (lags[k] * lags[k]) == Approx(up_left).epsilon(0.01));
    }
}

TEST_CASE_METHOD(testing::StageTest, "the length of its blur distinguishes a blurred picture from one of a plain wall")
{
    for (const int steps : {3, 5, 7})
    {
        // The fourth is blurred and darker; three show another wall with hardly any texture.
        std::vector<BlurView> views;
        for (std::uint64_t i = 0; i < 8; ++i)
            if (i >= 4 && i < 7)
                views.push_back(view_of(picture_of(0.1, 1, i), 5));
            else
                views.push_back(view_of(picture_of(1, i == 3 ? steps : 1, i, i == 3 ? 0.7 : 1), 0));
        const std::vector<double> blur = blur_px(views, run);
        CHECK(blur[3] == Approx(std::sqrt(steps * steps - 1)).epsilon(0.2));
        for (std::size_t i = 0; i < blur.size(); ++i)
            if (i != 3)
                CHECK(blur[i] < 0.5);
        testing::TestRun single(1);
        CHECK(blur_px(views, single) == blur);
    }
}

TEST_CASE_METHOD(testing::StageTest, "without depth pictures, whole pictures are compared with those beside them")
{
    std::vector<BlurView> views;
    for (std::uint64_t i = 0; i < 5; ++i)
        views.push_back({"walk", detail_of(picture_of(1, i == 2 ? 6 : 1, i)), {}});
    const std::vector<double> blur = blur_px(views, run);
    CHECK(blur[2] > 3);
    CHECK(blur[1] < 0.5);
    CHECK(blur[4] < 0.5);
    CHECK(needed_views(views, blur, {true, true, false, true, true}, run).empty());
    // Frames of another recording are not compared.
    views[2].sequence = "other";
    CHECK(blur_px(views, run)[2] == 0);
}

TEST_CASE_METHOD(testing::StageTest, "of the dropped views that see a surface by themselves the least blurred stays")
{
    const Raster8 picture = picture_of(1, 1, 1);
    // Pictures are 2.67 m wide there.
    const std::vector<BlurView> views{view_of(picture, 0), view_of(picture, 5), view_of(picture, 5.02), view_of(picture, 0.01),
                                      view_of(picture, 4.98)};
    CHECK(needed_views(views, {0, 7, 4, 2, 5}, {true, false, false, false, false}, run) == std::vector<std::size_t>{2});
    CHECK(needed_views(views, {0, 7, 4, 2, 5}, {true, true, false, false, false}, run).empty());
}

TEST_CASE_METHOD(testing::StageTest, "the stage drops the blurred frame, by the depth pictures, and reports all of them")
{
    Frames frames;
    for (std::uint64_t i = 0; i < 5; ++i)
    {
        Frame frame = testing::frame("frame-" + std::to_string(i), testing::camera(width, height, 120));
        testing::set_color_picture(frame, folder.path(), picture_of(1, i == 2 ? 7 : 1, i));
        testing::set_depth_picture(frame, folder.path(), RasterF(width, height, 1, 2.0F));
        frames.frames.push_back(frame);
    }
    testing::run_stage(FRESCO_PLUGIN_FILE, "frames.sharpest", Value::Map{}, {{"frames", std::make_shared<Frames>(frames)}},
                       folder.path() / "out", run, {{"image_io", std::make_shared<testing::RawImages>()}});
    CHECK(Frames::load({folder.path() / "out/frames", {}})->frames.size() == 4);
    const Value& judged = run.reported.at("judged_frames");
    CHECK(judged.at("kept") == Value::List{true, true, false, true, true});
    CHECK(judged.at("beyond") == Value::List{false, false, true, false, false});
    CHECK(judged.at("values").as_list().at(2).as_double() > judged.at("most").as_double());
}
