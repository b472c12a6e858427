#include "checkpoint.h"
#include "fakes.h"
#include "real_components.h"

#include <far_device.h>
#include <fresco/testing_scenes.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include "catch.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

using namespace fakes;
using fresco::optimize::LoopOptions;

namespace
{

/// Is not finite in step `bad_step` the first time, and refuses what follows from that.
std::shared_ptr<Loss> breaking_loss(std::int64_t bad_step)
{
    return std::make_shared<PictureLoss>(
        [bad_step, broken = false](Part& part) mutable
        {
            const auto mean = ordered_mean(part.image());
            if (!std::isfinite(mean.item<double>()))
                throw Error("the picture is not finite");
            const bool breaks = part.step() == bad_step && !std::exchange(broken, true);
            return breaks ? mean / 0.0 : -mean;
        });
}

/// Moves each value that the view sees against its gradient's sign. Supports only the processor, as a rule does by default.
struct SignRule final : OptimizerRule
{
    void attach(const std::vector<TextureParameter>&) override {}
    double step(std::vector<TextureParameter>& parameters, const Evaluate& evaluate, double rate, double) override
    {
        const auto evaluation = evaluate();
        for (std::size_t i = 0; i < parameters.size(); ++i)
        {
            const auto& [texels, values] = evaluation.gradients.at(i);
            REQUIRE(parameters[i].values.device().is_cpu());
            parameters[i].values.index_add_(0, texels, values.sign() * -rate);
        }
        return evaluation.loss;
    }
    TensorMap state() const override { return {}; }
    void restore(const TensorMap&) override {}
};

struct Room
{
    testing::TemporaryFolder folder{};
    std::vector<int> heights{20, 30};
    int last_block = 2;
    optimize::Values values = optimize::Values::display;
    bool corners = false;  ///< Only the corners of a view see the wall.
    Wall wall{folder.path() / "wall", 4, heights};
    /// The right half of every view is too steep for the fine style.
    std::shared_ptr<const UvMaps> maps =
        written_uv_maps(folder.path() / "maps", wall.frames, heights,
                        [this](std::size_t view, int width, int height)
                        {
                            auto map = wall_map(view, 4, width, height);
                            for (int y = 0; y < height; ++y)
                                for (int x = 0; x < width; ++x)
                                {
                                    map.cosine.at(x, y) = 2 * x < width ? 0.8F : 0.4F;
                                    const bool out =
                                        std::abs(5 * x - 2 * width) < width * 3 / 2 || std::abs(2 * y - height) < height / 2;
                                    if (corners && out)
                                        map.valid.at(x, y) = 0;
                                }
                            return map;
                        });
    Raster8 style = testing::picture(64, 64, [](int x, int y, int c) { return 40 + (3 * (64 * y + x) + c) * 37 % 150; });
    std::filesystem::path weights = random_vgg19(folder.path(), last_block);

    struct Result
    {
        Texture texture;
        std::vector<double> losses;
        std::int64_t waits = 0;
        std::int64_t rollbacks = 0;
        std::optional<optimize::Checkpoint> checkpoint;  ///< After five steps.
    };

    Result painted(const std::map<std::string, Value>& losses, const torch::Device& device, int repeats,
                   const std::string& rule = "optimizer.adam", const std::string& mode = "visible")
    {
        testing::TestFactory factory;
        const auto network = made<FeatureNetwork>(
            "features.vgg19", Value::Map{{"weights", weights.string()}, {"convolutions", "libtorch"}}, factory);
        factory.add("features.vgg19", [&] { return network; });
        std::map<std::string, std::shared_ptr<Loss>> components;
        for (const auto& [type, options] : losses)
            components.emplace(type, type == "breaking" ? breaking_loss(options.as_int()) : made<Loss>(type, options, factory));
        const auto texture = made<TextureRepresentation>("texture.laplacian", Value::Map{}, factory);
        const std::shared_ptr<OptimizerRule> steps =
            rule == "signs" ? std::make_shared<SignRule>() : made<OptimizerRule>(rule, Value::Map{{"mode", mode}}, factory);
        LoopOptions options = optimize::short_loop(64, repeats, device);
        options.values = values;
        options.init = optimize::Init::frames;
        options.lambda_r = 0.01;
        options.levels.angle_limit_deg = 60;
        options.checkpoint_steps = losses.contains("breaking") ? 2 : mode == "dense" ? 5 : 0;
        testing::TestRun run;
        testing::forget_far_traffic();
        Result result;
        result.texture = optimize::optimized_texture({*maps, wall.frames, style}, {components, *texture, *steps}, options, run);
        result.waits = testing::far_traffic().wait_count();
        result.losses = run.metrics.at("loss");
        if (const auto* rollbacks = run.reported.find("rollbacks"))
            result.rollbacks = rollbacks->as_int();
        result.checkpoint = optimize::Checkpoint::read(run.checkpoint_folder() / "checkpoint.safetensors");
        return result;
    }
};

/// Root mean square: where rounding changes which feature is nearest, Adam makes a whole step of it in a few texels.
double distance(const Texture& a, const Texture& b)
{
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t layer = 0; layer < a.layers.size(); ++layer)
        for (std::size_t i = 0; i < a.layers[layer].values.size(); ++i, ++count)
            sum += std::pow(static_cast<double>(a.layers[layer].values[i] - b.layers[layer].values[i]), 2);
    return std::sqrt(sum / static_cast<double>(count));
}

/// A graphics card where there is one, else the far one.
torch::Device other_device()
{
    return at::hasCUDA() ? torch::Device(torch::kCUDA, 0) : testing::far_device();
}

const Value on_network = Value::Map{{"type", "features.vgg19"}};

}  // namespace

TEST_CASE("every loss gives on another device what it gives on the processor, and no step waits for it")
{
    Room room;
    const std::vector<std::map<std::string, Value>> all{
        {{"loss.gram", Value::Map{{"targets", "both"}, {"average_views_count", 2}, {"features", on_network}}},
         {"loss.content", Value::Map{{"features", on_network}}}},
        {{"loss.gram", Value::Map{{"targets", "both"}, {"rule", "released"}, {"features", on_network}}},
         {"loss.content", Value::Map{{"features", on_network}, {"layers", "relu2_1"}}}}};
    for (const auto& losses : all)
    {
        CAPTURE(losses.begin()->first);
        const auto near = room.painted(losses, torch::kCPU, 2);
        CHECK(near.waits == 0);
        const auto far = room.painted(losses, other_device(), 2);
        REQUIRE(far.losses.size() == near.losses.size());
        CHECK(far.losses.front() == Approx(near.losses.front()).epsilon(1e-4));
        CHECK(far.losses.back() == Approx(near.losses.back()).epsilon(1e-3));
        CHECK(distance(far.texture, near.texture) < 5e-3);
        if (other_device().is_cuda())
            continue;
        const auto longer = room.painted(losses, testing::far_device(), 3);
        CHECK(longer.losses.size() > far.losses.size());
        CHECK(longer.waits == far.waits);
        const auto traffic = testing::far_traffic();
        CHECK(traffic.events_recorded > 0);
        CHECK(traffic.events_awaited == traffic.events_recorded);
    }
}

TEST_CASE("parts of levels are encoded on a sheet as they are one by one")
{
    Room room{{}, {40, 240}, 2, optimize::Values::network, true};
    const std::map<std::string, Value> losses{{"loss.gram", Value::Map{{"targets", "both"}, {"features", on_network}}},
                                              {"loss.content", Value::Map{{"features", on_network}}}};
    const auto near = room.painted(losses, torch::kCPU, 2);
    const auto far = room.painted(losses, other_device(), 2);
    CHECK(far.losses.front() == Approx(near.losses.front()).epsilon(1e-4));
    CHECK(far.losses.back() == Approx(near.losses.back()).epsilon(1e-3));
    CHECK(distance(far.texture, near.texture) < 5e-3);
}

TEST_CASE("every texel is stepped on another device as on the processor, and a checkpoint holds what it was written for")
{
    Room room;
    const std::map<std::string, Value> gram{{"loss.gram", Value::Map{{"features", on_network}}}};
    const auto near = room.painted(gram, torch::kCPU, 2, "optimizer.adam", "dense");
    const auto far = room.painted(gram, other_device(), 2, "optimizer.adam", "dense");
    REQUIRE(near.losses.size() == 8);
    CHECK(far.losses.back() == Approx(near.losses.back()).epsilon(1e-3));
    CHECK(distance(far.texture, near.texture) < 5e-3);
    REQUIRE(far.checkpoint);
    CHECK(far.checkpoint->step == 5);
    const auto& kept = far.checkpoint->parameters.begin()->second;
    const auto& expected = near.checkpoint->parameters.begin()->second;
    CHECK((kept - expected).pow(2).mean().sqrt().item<double>() < 5e-3);
    // Three steps later it is another texture.
    const auto last = at::from_blob(const_cast<float*>(near.texture.layers[0].values.data()), expected.sizes(), at::kFloat);
    CHECK((last - expected).pow(2).mean().sqrt().item<double>() > 1e-2);
}

TEST_CASE("a rule that only runs on the processor does, whatever the device")
{
    Room room;
    const std::map<std::string, Value> gram{{"loss.gram", Value::Map{{"features", on_network}}}};
    const auto near = room.painted(gram, torch::kCPU, 1, "signs");
    const auto far = room.painted(gram, other_device(), 1, "signs");
    CHECK(far.losses.back() == Approx(near.losses.back()).epsilon(1e-3));
    CHECK(distance(far.texture, near.texture) < 5e-3);
}

TEST_CASE("a step that is not finite is found on another device as on the processor, though a step later")
{
    Room room;
    // Steps 1 and 2 and then all eight, as a checkpoint is only due before step 3; or steps 1 to 3, and 3 to 8 from that one on.
    for (const auto& [bad_step, steps] : {std::pair{2, 2 + 8}, {3, 3 + 6}})
    {
        const std::map<std::string, Value> losses{{"breaking", bad_step}};
        const auto near = room.painted(losses, torch::kCPU, 2, "optimizer.adam", "dense");
        const auto far = room.painted(losses, other_device(), 2, "optimizer.adam", "dense");
        CHECK(near.losses.size() == static_cast<std::size_t>(steps));
        CHECK(far.losses.size() == near.losses.size());
        CHECK(near.rollbacks == 1);
        CHECK(far.rollbacks == 1);
        CHECK(distance(far.texture, near.texture) < 5e-3);
    }
}

TEST_CASE("a step of the paper's method sends at most 260 operators to a device")
{
    Room room{{}, {64, 80, 96, 112}, 5, optimize::Values::network};
    const std::map<std::string, Value> losses{
        {"loss.gram",
         Value::Map{{"targets", "both"}, {"layers", "relu1_1, relu2_1, relu3_1, relu4_1, relu5_1"}, {"features", on_network}}},
        {"loss.content", Value::Map{{"layers", "relu4_2"}, {"features", on_network}}}};
    // Each visit repeats the step of the one before; what a visit begins with does not count.
    const auto sent = [&](int repeats)
    {
        const auto result = room.painted(losses, testing::far_device(), repeats, "optimizer.adam", "dense");
        std::int64_t launches = 0;
        for (const auto& [name, count] : testing::far_traffic().launches)
            launches += count;
        return std::pair{static_cast<std::int64_t>(result.losses.size()), launches};
    };
    const auto [steps, launches] = sent(2);
    const auto [more_steps, more_launches] = sent(3);
    CAPTURE((more_launches - launches) / (more_steps - steps));
    CHECK(more_launches - launches <= 260 * (more_steps - steps));
}
