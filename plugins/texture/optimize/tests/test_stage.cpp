#include "catch.h"
#include "checkpoint.h"
#include "fakes.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <ATen/Parallel.h>
#include <ATen/ops/full.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

using namespace fakes;

namespace
{

Raster8 style_picture()
{
    return testing::picture(96, 72, [](int x, int y, int c) { return 40 + (3 * (96 * y + x) + c) * 37 % 150; });
}

/// Paints the wall by the built plugin, with fake losses and the real texture and rule.
struct Studio
{
    testing::TemporaryFolder folder;
    Wall wall;
    int runs = 0;

    explicit Studio(std::size_t views = 6, const std::vector<int>& heights = {30}) : wall(folder.path() / "wall", views, heights)
    {
    }

    static Value options(const Value& losses, Value::Map more)
    {
        Value options = Value::Map{{"size_px", 64},
                                   {"repeats_count", 3},
                                   {"device", "cpu"},
                                   {"losses", losses},
                                   {"texture", Value::Map{{"type", "texture.laplacian"}}},
                                   {"optimizer", Value::Map{{"type", "optimizer.adam"}, {"mode", "visible"}, {"beta2", 0.99}}}};
        for (auto& [name, value] : more)
            options.set(name, value);
        return options;
    }

    /// Runs the built plugin; the texture's folder.
    std::filesystem::path paint(testing::TestRun& run, const Value& options, const std::shared_ptr<Texture>& start = nullptr)
    {
        testing::TestFactory factory;
        factory.add("texture.laplacian",
                    [] { return testing::make_from_plugin<Component>(FRESCO_PLUGIN_texture_laplacian, "texture.laplacian"); });
        factory.add("optimizer.adam",
                    [] { return testing::make_from_plugin<Component>(FRESCO_PLUGIN_optimizer_adam, "optimizer.adam"); });
        factory.add("features.half", [] { return std::make_shared<HalfNetwork>(); });
        factory.add("camera", camera_loss);
        factory.add("mean", [] { return std::make_shared<MeanLoss>(); });
        factory.add("fragile", fragile_loss);
        factory.add("asking", [] { return std::make_shared<AskingLoss>(0); });
        const auto stage = testing::make_from_plugin<Stage>(FRESCO_PLUGIN_FILE, "texture.optimize");
        const auto out = folder.path() / ("run" + std::to_string(runs++));
        testing::Inputs inputs{{"uvmaps", wall.maps},
                               {"frames", std::make_shared<Frames>(wall.frames)},
                               {"style", std::make_shared<Image>(style_picture())}};
        if (start)
            inputs["start"] = start;
        testing::run_stage(*stage, options, inputs, out, run, factory);
        return out / "texture";
    }

    std::filesystem::path paint(const Value& options)
    {
        testing::TestRun run;
        return paint(run, options);
    }
};

std::vector<std::vector<std::byte>> bytes_in(const std::filesystem::path& texture)
{
    std::vector<std::vector<std::byte>> result;
    for (const char* name :
         {"layer_0.packed", "layer_1.packed", "layer_2.packed", "layer_3.packed", "seen.packed", "texture.json"})
        result.push_back(read_file(texture / name));
    return result;
}

const Value fragile = Value::Map{{"glass", Value::Map{{"type", "fragile"}}}};
const Value on_camera = Value::Map{{"camera", Value::Map{{"type", "camera"}}}};
const Value mean_losses = Value::Map{{"a", Value::Map{{"type", "mean"}, {"features", Value::Map{{"type", "features.half"}}}}},
                                     {"b", Value::Map{{"type", "camera"}, {"weight", 0.3}}}};

/// The color of a texture of displayed values, or of a network's, at a place.
Vec3d shown(const Texture& texture, double u, double v)
{
    Vec3d sum;
    for (const auto& layer : texture.layers)
    {
        std::array<float, 3> value{};
        sample_bilinear(layer, static_cast<float>(u), static_cast<float>(v), value.data());
        sum += Vec3d{double{value[0]}, double{value[1]}, double{value[2]}};
    }
    return texture.values == "display" ? sum : Vec3d{sum.z + 123.68, sum.y + 116.779, sum.x + 103.939} * (1 / 255.0);
}

Vec3d painted(double u, double v)
{
    return vec_cast<double>(painting(u, v));
}

/// The wall's painting as a texture.
std::shared_ptr<Texture> wall_texture()
{
    auto texture = std::make_shared<Texture>(testing::blank_texture(64, 0));
    RasterF& layer = texture->layers.front();
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
        {
            const Vec3f color = painting((x + 0.5) / 64, 1 - (y + 0.5) / 64);
            std::ranges::copy(std::array{color.x, color.y, color.z}, &layer.at(x, y));
        }
    texture->seen = Raster8(64, 64, 1, 1);
    return texture;
}

/// Runs the stage until it is canceled at the `calls`-th time that it asks.
bool is_canceled(Studio& studio, testing::TestRun& run, const Value& options, int calls)
{
    run.cancel_after(calls);
    bool is_canceled = false;
    try
    {
        studio.paint(run, options);
    }
    catch (const Canceled&)
    {
        is_canceled = true;
    }
    run.cancel_after(1000);
    return is_canceled;
}

struct WithStudio
{
    Studio studio;
    testing::TestRun run;
};

}  // namespace

TEST_CASE_METHOD(WithStudio, "a texture pulled to the camera pictures becomes the painting, whatever it stores")
{
    for (const char* values : {"display", "network"})
        for (const char* init : {"zeros", "frames"})
        {
            CAPTURE(values, init);
            testing::TestRun run;
            const auto folder =
                studio.paint(run, Studio::options(on_camera, {{"epochs", 16},
                                                              {"values", values},
                                                              {"init", init},
                                                              {"rate", std::string(values) == "network" ? 5.0 : 0.02},
                                                              {"gradient_scaling", "none"}}));
            const auto texture = Texture::load({folder, {}});
            CHECK(texture->values == values);
            REQUIRE(texture->layers.size() == 4);
            REQUIRE(run.metrics.at("loss").size() == 6 * 3 * 16);
            CHECK(run.metrics.at("loss").back() < 2e-4);
            CHECK(run.reported.at("steps").as_int() == 288);
            // The middle of the last window.
            CHECK(length(shown(*texture, 0.7, 0.3) - painted(0.7, 0.3)) < 0.04);
            CHECK(run.reported.at("seen_share").as_double() == Approx(0.65).margin(0.25));
        }
}

TEST_CASE_METHOD(WithStudio, "a start texture that is wired is what the texture begins as, recolored to the style")
{
    const auto start = std::make_shared<Texture>(testing::blank_texture(32, 0.9F));
    start->seen = Raster8(32, 32, 1, 1);
    Vec3d mean;
    const Raster8 style = style_picture();
    for (std::size_t i = 0; i < style.values.size(); i += 3)
        mean +=
            Vec3d{double(style.values[i]), double(style.values[i + 1]), double(style.values[i + 2])} * (1 / 255.0 / (96 * 72));
    const auto folder = studio.paint(run, Studio::options(on_camera, {{"epochs", 1}, {"rate", 0}}), start);
    CHECK(length(shown(*Texture::load({folder, {}}), 0.7, 0.3) - mean) < 0.01);
}

TEST_CASE_METHOD(WithStudio, "frames without a picture show the start texture, whatever the texture begins as")
{
    const auto options = [](const char* init) {
        return Studio::options(on_camera, {{"epochs", 16}, {"init", init}, {"gradient_scaling", "none"}});
    };
    for (const std::size_t view : {0, 5})
        studio.wall.frames.frames[view].color_picture = {};
    for (const char* init : {"zeros", "frames"})
    {
        CAPTURE(init);
        testing::TestRun run;
        const auto texture = Texture::load({studio.paint(run, options(init), wall_texture()), {}});
        // Only the last view, which has no picture, sees this place.
        CHECK(length(shown(*texture, 0.95, 0.3) - painted(0.95, 0.3)) < 0.04);
    }
    CHECK_THROWS_WITH(studio.paint(options("frames")),
                      Catch::Contains("frame walk/frame-0 has no color picture") && Catch::Contains("wire 'start'"));
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
    auto other = options;
    other.set("seed", 5);
    CHECK((bytes_in(studio.paint(other)) != results[0]));
}

TEST_CASE_METHOD(WithStudio, "errors name what is wrong")
{
    CHECK_THROWS_WITH(studio.paint(Studio::options(Value::Map{}, {})), Catch::Contains("losses"));
    CHECK_THROWS_WITH(studio.paint(Studio::options(on_camera, {{"size_px", 100}})), Catch::Contains("multiple of 8"));
    CHECK_THROWS_WITH(studio.paint(Studio::options(on_camera, {{"stop_gain", 0.1}})), Catch::Contains("held_out_count"));
    if (!at::hasCUDA())
        CHECK_THROWS_WITH(studio.paint(Studio::options(on_camera, {{"device", "cuda"}})), Catch::Contains("cuda"));
    Studio blind;
    UvMaps nothing = *blind.wall.maps;
    for (auto& view : nothing.views)
        view.valid_pixels = {0};
    blind.wall.maps = std::make_shared<UvMaps>(nothing);
    CHECK_THROWS_WITH(blind.paint(Studio::options(on_camera, {})), Catch::Contains("valid pixel"));
}

TEST_CASE_METHOD(WithStudio, "the released protocol clamps layers in place of their sum")
{
    const auto folder = studio.paint(Studio::options(
        on_camera, {{"epochs", 2}, {"values", "network"}, {"init", "zeros"}, {"rate", 120.0}, {"protocol", "released_scannet"}}));
    std::vector<float> values;
    const auto texture = Texture::load({folder, {}});
    for (const auto& layer : texture->layers)
        values.insert(values.end(), layer.values.begin(), layer.values.end());
    CHECK(std::ranges::min(values) == Approx(-123.68));
    CHECK(std::ranges::max(values) == Approx(151.061));
}

TEST_CASE("losses are measured on held-out views, and a run that gains nothing more ends early with the same bytes, also resumed")
{
    Studio studio(9);
    const auto options = [&](double stop_gain)
    {
        return Studio::options(on_camera, {{"held_out_count", 2},
                                           {"stop_gain", stop_gain},
                                           {"epochs", 30},
                                           {"rate", 0.05},
                                           {"decay_start", 1.0},
                                           {"checkpoint_steps", 7}});
    };
    testing::TestRun all;
    studio.paint(all, options(0));
    CHECK(all.reported.at("steps").as_int() == 630);
    const auto& measured = all.reported.at("held_out").as_list();
    REQUIRE(measured.size() == 17);
    CHECK(measured[16].at("step").as_int() == 630);
    CHECK(measured[16].at("loss").as_double() < 0.5 * measured[0].at("loss").as_double());
    CHECK(measured[16].at("camera_loss") == measured[16].at("loss"));

    testing::TestRun early;
    const auto texture = bytes_in(studio.paint(early, options(0.01)));
    const auto steps = early.reported.at("steps").as_int();
    CHECK(steps >= 160);
    CHECK(steps < 600);
    CHECK(steps % 40 == 0);

    testing::TestRun resumed;
    CHECK(is_canceled(studio, resumed, options(0.01), static_cast<int>(4 + steps / 2)));  // 4 batches of views first
    CHECK((bytes_in(studio.paint(resumed, options(0.01))) == texture));
    CHECK(resumed.reported.at("held_out").as_list().size() == early.reported.at("held_out").as_list().size());
}

TEST_CASE_METHOD(WithStudio, "the camera picture is encoded once per visit")
{
    const int before = HalfNetwork::all_encoded;
    studio.paint(Studio::options(mean_losses, {{"max_steps", 12}, {"repeats_count", 4}}));
    // The style picture, 12 rendered views, and the camera pictures of three visits.
    CHECK(HalfNetwork::all_encoded - before == 1 + 12 + 3);
}

TEST_CASE_METHOD(WithStudio, "a run that is canceled, or killed, goes on to the same bytes")
{
    for (const char* mode : {"visible", "dense"})
    {
        auto options = Studio::options(mean_losses, {{"epochs", 2}, {"lambda_r", 0.01}, {"checkpoint_steps", 0}});
        options.set("optimizer", Value::Map{{"type", "optimizer.adam"}, {"mode", mode}});
        const auto expected = bytes_in(studio.paint(options));

        testing::TestRun interrupted;
        CHECK(is_canceled(studio, interrupted, options, 3 + 14));  // 3 batches of views, then in the middle of a visit
        CHECK(interrupted.metrics.at("loss").size() == 13);
        CHECK((bytes_in(studio.paint(interrupted, options)) == expected));
        CHECK(interrupted.metrics.at("loss").size() == 36);
        REQUIRE_FALSE(interrupted.messages.empty());
        CHECK(interrupted.messages.back() == "going on after step 13 of 36");

        // With periodic checkpoints too.
        options.set("checkpoint_steps", 10);
        testing::TestRun killed;
        CHECK(is_canceled(studio, killed, options, 3 + 21));
        CHECK((bytes_in(studio.paint(killed, options)) == expected));
    }
}

namespace
{

/// Cancels runs at each of the first `most` times that they ask, and ends them; the number that had made steps by then.
int check_resumed_anywhere(Studio& studio, const Value& options, int most, const std::vector<std::vector<std::byte>>& expected,
                           std::optional<std::size_t> steps = std::nullopt)
{
    int gone_on = 0;
    for (int calls = 1; calls < most; ++calls)
    {
        CAPTURE(calls);
        testing::TestRun run;
        const bool canceled = is_canceled(studio, run, options, calls);
        gone_on += canceled && !run.metrics["loss"].empty();
        if (!canceled)
            run.metrics["loss"].clear();
        CHECK((bytes_in(studio.paint(run, options)) == expected));
        if (steps)
            CHECK(run.metrics["loss"].size() == *steps);
    }
    return gone_on;
}

}  // namespace

TEST_CASE_METHOD(WithStudio, "stop_at_step ends with what the whole run has after that step, from its checkpoint or the start")
{
    auto options = Studio::options(mean_losses, {{"epochs", 2}, {"decay_start", 0.0}, {"checkpoint_steps", 5}});
    CHECK(is_canceled(studio, run, options, 3 + 14));
    CHECK(run.messages.back() == "stopped after step 13; stop_at_step: 13 makes that the result");
    // The newest checkpoint, and the last one before it.
    for (const auto& [end, resumed] :
         {std::pair(13, "going on after step 13 of 13"), std::pair(11, "going on after step 10 of 11")})
    {
        options.set("stop_at_step", end);
        const auto kept = bytes_in(studio.paint(run, options));
        CHECK(run.messages.back() == resumed);
        testing::TestRun whole;
        CHECK((bytes_in(studio.paint(whole, options)) == kept));
        CHECK(whole.metrics.at("loss").size() == static_cast<std::size_t>(end));
    }
    options.set("stop_at_step", 0);
    options.set("max_steps", 11);
    const auto other_rates = bytes_in(studio.paint(options));
    options.set("max_steps", 0);
    options.set("stop_at_step", 11);
    CHECK((bytes_in(studio.paint(options)) != other_rates));
}

TEST_CASE_METHOD(WithStudio, "a loss that asks within a step loses nothing when the run is canceled")
{
    const auto options = Studio::options(Value::Map{{"it", Value::Map{{"type", "asking"}}}}, {{"max_steps", 9}});
    CHECK(check_resumed_anywhere(studio, options, 24, bytes_in(studio.paint(options)), 9) >= 8);
}

TEST_CASE_METHOD(WithStudio, "what a run that ends without warning would lose is kept from time to time")
{
    const auto paint = [&](testing::TestRun& run, double checkpoint_seconds)
    {
        const std::map<std::string, std::shared_ptr<Loss>> losses{{"it", std::make_shared<AskingLoss>(9)}};
        const auto texture =
            testing::make_from_plugin<TextureRepresentation>(FRESCO_PLUGIN_texture_laplacian, "texture.laplacian");
        const auto rule = testing::make_from_plugin<OptimizerRule>(FRESCO_PLUGIN_optimizer_adam, "optimizer.adam");
        optimize::LoopOptions options = optimize::short_loop(64, 3);
        options.checkpoint_seconds = checkpoint_seconds;
        CHECK_THROWS_WITH(optimize::optimized_texture({*studio.wall.maps, studio.wall.frames, style_picture()},
                                                      {losses, *texture, *rule}, options, run),
                          Catch::Contains("broken"));
    };
    testing::TestRun nothing;
    paint(nothing, 0);
    CHECK(std::filesystem::is_empty(nothing.checkpoint_folder()));

    testing::TestRun killed;
    paint(killed, 1e-9);
    const auto kept = optimize::Checkpoint::read(killed.checkpoint_folder() / "interrupted.safetensors");
    REQUIRE(kept);
    CHECK(kept->step >= 1);
    CHECK(kept->step < 9);
}

TEST_CASE_METHOD(WithStudio, "a checkpoint that cannot take its place ends the run")
{
    std::filesystem::create_directories(run.checkpoint_folder() / "earlier.safetensors" / "in_the_way");
    const auto options = Studio::options(mean_losses, {{"max_steps", 9}, {"checkpoint_steps", 2}});
    CHECK_THROWS_WITH(studio.paint(run, options), Catch::Contains("cannot be renamed to earlier.safetensors"));
}

TEST_CASE_METHOD(WithStudio, "a flipped bit in a checkpoint is named and changes nothing")
{
    const auto options = Studio::options(mean_losses, {{"epochs", 1}, {"checkpoint_steps", 0}});
    const auto expected = bytes_in(studio.paint(options));
    CHECK(is_canceled(studio, run, options, 3 + 8));
    const auto file = run.checkpoint_folder() / "interrupted.safetensors";
    auto bytes = read_file(file);
    bytes[bytes.size() - bytes.size() / 4] ^= std::byte{1};
    write_file(file, bytes);
    CHECK((bytes_in(studio.paint(run, options)) == expected));
    CHECK(std::ranges::any_of(run.messages, [](auto& m) { return m.starts_with("warning: the checkpoint cannot be used"); }));
}

TEST_CASE_METHOD(
    WithStudio,
    "where a loss is not finite the run goes back and halves the rate, and ends with the same bytes when interrupted then")
{
    // Each of four layers moves by the rate, from 0.45 on: past 0.9 after three steps of 0.04, not after two of them and one of
    // 0.02.
    const auto options = [&](double rate)
    {
        return Studio::options(
            fragile, {{"rate", rate}, {"max_steps", 4}, {"decay_start", 1.0}, {"init", "color"}, {"checkpoint_steps", 2}});
    };
    testing::TestRun run;
    const auto expected = bytes_in(studio.paint(run, options(0.04)));
    CHECK(run.reported.at("rollbacks").as_int() == 1);
    // Steps 1 to 3, then steps 3 and 4 again from the checkpoint after step 2.
    CHECK(run.metrics.at("loss").size() == 5);
    testing::TestRun never;
    const auto slow = bytes_in(studio.paint(never, options(0.02)));
    CHECK(never.reported.find("rollbacks") == nullptr);
    CHECK((slow != expected));
    CHECK(check_resumed_anywhere(studio, options(0.04), 12, expected) >= 4);
    CHECK_THROWS_WITH(studio.paint(options(10)),
                      Catch::Contains("step 2") && Catch::Contains("glass") && Catch::Contains("3 times"));
}

TEST_CASE_METHOD(WithStudio, "a state that is bad when its checkpoint is due is thrown away, and the good one before it kept")
{
    // 0.45 at first, four layers: past 0.9 after four steps of 0.03, which is when a checkpoint is due. From the one after step 2
    // on at half the rate it is not; two checkpoints later it is again, so that the run goes back twice.
    const auto options = Studio::options(
        fragile, {{"rate", 0.03}, {"max_steps", 7}, {"decay_start", 1.0}, {"init", "color"}, {"checkpoint_steps", 2}});
    const auto expected = bytes_in(studio.paint(run, options));
    CHECK(run.reported.at("rollbacks").as_int() >= 2);
    check_resumed_anywhere(studio, options, 20, expected);
}
