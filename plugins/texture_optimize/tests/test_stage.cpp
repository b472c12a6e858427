#include "studio.h"

#include <fresco/error.h>

#include <ATen/Parallel.h>
#include <ATen/ops/full.h>

#include <array>

using namespace fakes;

namespace
{

std::array<float, 3> looked_up(const Texture& texture, double u, double v)
{
    std::array<float, 3> sum{};
    for (const auto& layer : texture.layers)
    {
        std::array<float, 3> value{};
        sample_bilinear(layer, static_cast<float>(u), static_cast<float>(v), value.data());
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += value[c];
    }
    return sum;
}

}  // namespace

TEST_CASE("a texture pulled to the camera pictures becomes the painting, whatever it stores")
{
    Studio studio;
    for (const char* values : {"display", "network"})
        for (const char* init : {"zeros", "frames"})
        {
            CAPTURE(values, init);
            const bool network = std::string(values) == "network";
            testing::TestRun run;
            const auto folder = studio.paint(run, Studio::options(camera_loss, {{"epochs", 16},
                                                                                {"values", values},
                                                                                {"init", init},
                                                                                {"rate", network ? 5.0 : 0.02},
                                                                                {"gradient_scaling", "none"}}));
            const auto texture = Texture::load({folder, {}});
            CHECK(texture->values == values);
            REQUIRE(texture->layers.size() == 4);
            const auto& losses = run.metrics.at("loss");
            REQUIRE(losses.size() == 6 * 3 * 16);
            CHECK(losses.back() < 2e-4);
            CHECK(run.reported.at("steps").as_int() == 288);
            // The middle of the last window.
            const auto found = looked_up(*texture, 0.7, 0.3);
            const auto wanted = painting(0.7, 0.3);
            const std::array<double, 3> rgb{wanted.x, wanted.y, wanted.z};
            const std::array<double, 3> mean{123.68, 116.779, 103.939};
            for (std::size_t c = 0; c < 3; ++c)
            {
                const double shown =
                    network ? (static_cast<double>(found[2 - c]) + mean[c]) / 255 : static_cast<double>(found[c]);
                CHECK(shown == Approx(rgb[c]).margin(0.03));
            }
            const double seen = run.reported.at("seen_share").as_double();
            CHECK(seen > 0.4);
            CHECK(seen < 0.9);
        }
}

TEST_CASE("a start texture that is wired is what the texture begins as, recolored to the style")
{
    Studio studio;
    const auto start = std::make_shared<Texture>();
    start->layers.emplace_back(32, 32, 3, 0.9F);
    start->seen = Raster8(32, 32, 1, 1);
    Vec3d mean;
    const Raster8 style = style_picture();
    const double pixels = static_cast<double>(style.values.size()) / 3;
    for (std::size_t i = 0; i < style.values.size(); i += 3)
        mean += Vec3d{style.values[i] / 255.0, style.values[i + 1] / 255.0, style.values[i + 2] / 255.0} * (1 / pixels);
    testing::TestRun run;
    const auto folder = studio.paint(run, Studio::options(camera_loss, {{"epochs", 1}, {"rate", 0}}), start);
    const auto found = looked_up(*Texture::load({folder, {}}), 0.7, 0.3);
    CHECK(static_cast<double>(found[0]) == Approx(mean.x).margin(0.01));
    CHECK(static_cast<double>(found[1]) == Approx(mean.y).margin(0.01));
    CHECK(static_cast<double>(found[2]) == Approx(mean.z).margin(0.01));
    // Before the losses are prepared, which takes long.
    const int encoded = HalfNetwork::all_encoded;
    CHECK_THROWS_WITH(studio.paint(run, Studio::options(mean_losses, {{"epochs", 1}, {"init", "noise"}}), start),
                      Catch::Contains("port 'start' is wired, but init is noise"));
    CHECK(HalfNetwork::all_encoded == encoded);
}

TEST_CASE("frames without a picture show the start texture, whatever the texture begins as")
{
    // The wall's painting, which the other views' pictures show.
    Studio studio;
    const auto start = std::make_shared<Texture>();
    RasterF& layer = start->layers.emplace_back(64, 64, 3);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
        {
            const Vec3f color = painting((x + 0.5) / 64, 1 - (y + 0.5) / 64);
            layer.at(x, y, 0) = color.x;
            layer.at(x, y, 1) = color.y;
            layer.at(x, y, 2) = color.z;
        }
    start->seen = Raster8(64, 64, 1, 1);
    const auto options = [](const char* init) {
        return Studio::options(camera_loss, {{"epochs", 16}, {"init", init}, {"gradient_scaling", "none"}});
    };
    for (const std::size_t view : {0, 5})
        studio.wall.frames.frames[view].color_picture = {};
    for (const char* init : {"zeros", "frames"})
    {
        CAPTURE(init);
        testing::TestRun run;
        const auto texture = Texture::load({studio.paint(run, options(init), start), {}});
        // What only the last view sees, which has no picture.
        const auto found = looked_up(*texture, 0.95, 0.3);
        const Vec3f wanted = painting(0.95, 0.3);
        CHECK(found[0] == Approx(wanted.x).margin(0.03));
        CHECK(found[1] == Approx(wanted.y).margin(0.03));
        CHECK(found[2] == Approx(wanted.z).margin(0.03));
    }
    // Before the losses are prepared, which takes long.
    testing::TestRun run;
    const int encoded = HalfNetwork::all_encoded;
    CHECK_THROWS_WITH(studio.paint(run, options("frames")),
                      Catch::Contains("frame walk/frame-0 has no color picture") && Catch::Contains("wire 'start'"));
    CHECK_THROWS_WITH(studio.paint(run, Studio::options(mean_losses, {{"depth_levels", true}, {"level_depth", "sensor"}}), start),
                      Catch::Contains("frame walk/frame-0 has no depth picture: set level_depth: mesh"));
    CHECK(HalfNetwork::all_encoded == encoded);
}

TEST_CASE("the texture's bytes do not depend on threads, levels together, and do on the seed")
{
    // Large enough for several pieces in every loop, and for torch to split its own reductions among the threads.
    Studio studio(3, {120, 240});
    const auto options = Studio::options(mean_losses, {{"epochs", 2}, {"repeats_count", 2}, {"size_px", 256}});
    std::vector<std::vector<std::vector<std::byte>>> results;
    for (const int threads : {1, 2})
    {
        testing::TestRun run(threads);
        results.push_back(bytes_in(studio.paint(run, options)));
    }
    CHECK((results[0] == results[1]));
    testing::TestRun run;
    auto other = options;
    other.set("seed", 5);
    CHECK((bytes_in(studio.paint(run, other)) != results[0]));
}

TEST_CASE("errors name what is wrong")
{
    Studio studio;
    testing::TestRun run;
    const Value exploding = Value::Map{{"boom", Value::Map{{"type", "exploding"}}}};
    CHECK_THROWS_WITH(studio.paint(run, Studio::options(exploding, {})), Catch::Contains("step 3") && Catch::Contains("boom"));
    CHECK_THROWS_WITH(studio.paint(run, Studio::options(Value::Map{}, {})), Catch::Contains("losses"));
    CHECK_THROWS_WITH(studio.paint(run, Studio::options(camera_loss, {{"size_px", 100}})), Catch::Contains("multiple of 8"));
    if (!at::hasCUDA())
        CHECK_THROWS_WITH(studio.paint(run, Studio::options(camera_loss, {{"device", "cuda"}})), Catch::Contains("cuda"));
    Studio blind;
    UvMaps nothing = *blind.wall.maps;
    for (auto& view : nothing.views)
        view.valid_pixels = {0};
    blind.wall.maps = std::make_shared<UvMaps>(nothing);
    CHECK_THROWS_WITH(blind.paint(run, Studio::options(camera_loss, {})), Catch::Contains("valid pixel"));
}

TEST_CASE("the released protocol clamps layers in place of their sum")
{
    Studio studio;
    testing::TestRun run;
    const auto folder = studio.paint(
        run,
        Studio::options(camera_loss,
                        {{"epochs", 2}, {"values", "network"}, {"init", "zeros"}, {"rate", 120.0}, {"protocol", "released"}}));
    const auto texture = Texture::load({folder, {}});
    double least = 0;
    double most = 0;
    for (const auto& layer : texture->layers)
    {
        const auto [low, high] = std::minmax_element(layer.values.begin(), layer.values.end());
        least = std::min(least, static_cast<double>(*low));
        most = std::max(most, static_cast<double>(*high));
    }
    CHECK(least == Approx(-123.68));
    CHECK(most == Approx(151.061));
}

TEST_CASE("max_steps and a subset of the heights are kept")
{
    Studio studio(4, {20, 30});
    testing::TestRun run;
    studio.paint(run, Studio::options(camera_loss, {{"max_steps", 5}, {"heights_px", Value::List{20}}, {"init", "color"}}));
    CHECK(run.metrics.at("loss").size() == 5);
}

TEST_CASE("losses are measured on held-out views, and a run that gains nothing more ends early with the same bytes, also resumed")
{
    Studio studio(9);
    const auto options = [&](double stop_gain)
    {
        return Studio::options(camera_loss, {{"held_out_count", 2},
                                             {"measure_steps", 5},
                                             {"stop_gain", stop_gain},
                                             {"epochs", 30},
                                             {"rate", 0.05},
                                             {"decay_start", 1.0},
                                             {"checkpoint_steps", 7}});
    };
    testing::TestRun all;
    studio.paint(all, options(0));
    CHECK(all.reported.at("views").as_int() == 7);
    CHECK(all.reported.at("held_out_views").as_int() == 2);
    CHECK(all.reported.at("steps").as_int() == 630);
    const auto& measured = all.reported.at("held_out").as_list();
    REQUIRE(measured.size() == 127);
    CHECK(measured[126].at("step").as_int() == 630);
    CHECK(measured[126].at("loss").as_double() < 0.5 * measured[0].at("loss").as_double());
    CHECK(measured[126].at("camera_loss") == measured[126].at("loss"));
    CHECK(measured[126].at("seconds").as_double() > measured[0].at("seconds").as_double());
    CHECK(all.reported.at("losses_at_last_step").at("camera").as_double() == Approx(all.metrics.at("loss").back()));

    testing::TestRun early;
    const auto texture = bytes_in(studio.paint(early, options(0.01)));
    const auto steps = early.reported.at("steps").as_int();
    CHECK(steps >= 20);
    CHECK(steps < 600);
    CHECK(steps % 5 == 0);

    testing::TestRun resumed;
    resumed.cancel_after(static_cast<int>(4 + steps / 2));  // 4 batches of views first
    CHECK_THROWS_AS(studio.paint(resumed, options(0.01)), Canceled);
    CHECK((bytes_in(studio.paint(resumed, options(0.01))) == texture));
    CHECK(resumed.reported.at("steps").as_int() == steps);
    CHECK(resumed.reported.at("held_out").as_list().size() == early.reported.at("held_out").as_list().size());

    testing::TestRun wrong;
    CHECK_THROWS_WITH(studio.paint(wrong, Studio::options(camera_loss, {{"stop_gain", 0.1}})), Catch::Contains("held_out_count"));
    CHECK_THROWS_WITH(studio.paint(wrong, Studio::options(camera_loss, {{"held_out_count", 9}})),
                      Catch::Contains("only 9 views"));
}

TEST_CASE("the reference way of executing gives the same texture, and encodes more for it")
{
    Studio studio;
    testing::TestRun run;
    const auto encoded = [&](const char* execution, std::vector<std::vector<std::byte>>& bytes)
    {
        const int before = HalfNetwork::all_encoded;
        bytes = bytes_in(
            studio.paint(run, Studio::options(mean_losses, {{"max_steps", 12}, {"repeats_count", 4}, {"execution", execution}})));
        return HalfNetwork::all_encoded - before;
    };
    std::vector<std::vector<std::byte>> active;
    std::vector<std::vector<std::byte>> reference;
    const int of_active = encoded("active", active);
    CHECK(encoded("reference", reference) >= of_active + 9);  // the camera picture of three visits, three times more
    CHECK((active == reference));
}
