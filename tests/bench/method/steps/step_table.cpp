#include "components.h"
#include "evaluation.h"
#include "forked_case.h"
#include "method_tables.h"
#include "scene.h"

#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/tensor.h>
#include <fresco/torch/tensor_memory.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <climits>
#include <cmath>
#include <malloc.h>

namespace bench
{
namespace
{

using namespace fresco::optimize;

constexpr double repeats = 10;  ///< Consecutive steps on a view, as in the paper: the first one encodes the camera picture.
constexpr double lambda_r = 5000;
constexpr std::array heights{256, 432, 608, 784};

/// A network and the paper's losses on it.
struct Network
{
    const char* name;
    const char* last;
    const char* style_layers;
    std::vector<double> style_weights;
    const char* content_layer;
};

const std::array networks{
    Network{"conv1_1..conv3_1", "conv3_1", "relu1_1, relu2_1, relu3_1", {1000, 1000, 10}, "relu3_1"},
    Network{"full", "conv5_1", "relu1_1, relu2_1, relu3_1, relu4_1, relu5_1", {1000, 1000, 10, 10, 1000}, "relu4_2"}};

/// Distances in meters from the picture's lower to its upper border, as far as depth levels are concerned.
struct Room
{
    const char* levels;
    double nearest;
    double farthest;
};

constexpr std::array rooms{Room{"1", 0.8, 1.9}, Room{"2", 2.1, 3.3}, Room{"4", 1.2, 6.0}};

std::map<std::string, std::shared_ptr<fresco::Loss>> made_losses(Components& components, const Network& network, bool reference,
                                                                 const std::filesystem::path& weights)
{
    using Map = fresco::Value::Map;
    const fresco::Value features =
        Map{{"type", "features.vgg19"}, {"weights", weights.string()}, {"convolutions", reference ? "plain" : "auto"}};
    fresco::Value::List factors(network.style_weights.begin(), network.style_weights.end());
    std::map<std::string, std::shared_ptr<fresco::Loss>> losses;
    losses["style"] = components.make<fresco::Loss>(Map{{"type", "loss.gram"},
                                                        {"weight", 1e-4},
                                                        {"center", false},
                                                        {"targets", "both"},
                                                        {"layers", network.style_layers},
                                                        {"layer_weights", std::move(factors)},
                                                        {"features", features}});
    losses["content"] = components.make<fresco::Loss>(
        Map{{"type", "loss.content"}, {"weight", 70.0}, {"layers", network.content_layer}, {"features", features}});
    return losses;
}

/// All that a run has before its first step on one view.
struct Studio
{
    Components components;
    std::map<std::string, std::shared_ptr<fresco::Loss>> losses;
    std::shared_ptr<fresco::TextureRepresentation> texture;
    std::shared_ptr<fresco::OptimizerRule> rule;
    ViewData view;

    Studio(const Network& network, const Room& room, bool reference, const MethodSettings& settings,
           const std::filesystem::path& weights)
    {
        at::set_num_threads(settings.threads);
        losses = made_losses(components, network, reference, weights);
        std::vector<std::shared_ptr<fresco::Loss>> all;
        for (const auto& [name, loss] : losses)
            all.push_back(loss);
        prepare(all, heights.front());
        texture = components.make<fresco::TextureRepresentation>(fresco::Value::Map{{"type", "texture.laplacian"}});
        texture->allocate(settings.step_size_px);
        // As the preset has it.
        rule = components.make<fresco::OptimizerRule>(
            fresco::Value::Map{{"type", "optimizer.adam"}, {"mode", "dense"}, {"untouched", reference ? "step" : "skip"}});
        rule->attach(texture->parameters());
        load_levels(room);
    }

    /// As load_view does it.
    void load_levels(const Room& room)
    {
        std::vector<fresco::UvMap> maps;
        for (const int height : heights)
            maps.push_back(generated_view(height));
        fresco::RasterF depth = maps[0].depth;
        for (int y = 0; y < depth.height; ++y)
            for (int x = 0; x < depth.width; ++x)
                depth.at(x, y) *= static_cast<float>((room.farthest - (room.farthest - room.nearest) * y / depth.height) /
                                                     static_cast<double>(std::max(depth.at(x, y), 1e-3F)));
        const AngleRule angle{30, Protocol::paper};
        const auto pixels = depth_levels(maps, depth, 0.25, angle);
        const auto shares = level_shares(pixels);
        for (std::size_t i = 0; i < maps.size(); ++i)
        {
            if (!(shares[i] > 0))
                continue;
            LevelData level;
            level.height_px = heights.at(i);
            level.view = texture->make_view(maps[i]);
            level.valid = maps[i].valid;
            level.pixels = pixels[i];
            level.factor = gradient_factor(maps[i], pixels[i], GradientScaling::angle);
            level.share = shares[i];
            level.camera = fresco::to_tensor(generated_camera_picture(maps[i].valid.width, maps[i].valid.height));
            view.levels.push_back(std::move(level));
            view.numbers.push_back(static_cast<int>(i));
        }
    }

    double step(Evaluator& evaluator)
    {
        auto& parameters = texture->parameters();
        return rule->step(
            parameters, [&] { return evaluator.evaluate(0, {}, view, "generated", parameters.size()); }, 1, lambda_r);
    }

    std::int64_t texels() const
    {
        std::int64_t sum = 0;
        for (const auto& parameter : const_cast<fresco::TextureRepresentation&>(*texture).parameters())
            sum += parameter.values.size(0);
        return sum;
    }
};

/// Multiply-adds of one forward pass.
double multiply_adds(const Network& network, int width, int height)
{
    double sum = 0;
    for (const auto& shape : vgg19_shapes(network.last))
        sum += 9.0 * static_cast<double>(shape.inputs * shape.outputs) * (width / shape.stride) * (height / shape.stride);
    return sum;
}

/// Of a step's forward passes: the image's, and the camera's as often as it is encoded.
double network_work(const Studio& studio, const Network& network, bool reference)
{
    double sum = 0;
    for (const auto& level : studio.view.levels)
    {
        if (reference || level.cropped.empty())
            sum += multiply_adds(network, level.pixels.all.width, level.pixels.all.height);
        else
            for (const auto& crop : level.cropped.begin()->second.crops)
                sum += multiply_adds(network, crop.encoded.x1 - crop.encoded.x0, crop.encoded.y1 - crop.encoded.y0);
    }
    return sum * (reference ? 2 : 1 + 1 / repeats);
}

/// As the host has it for its stages.
void keep_freed_memory()
{
#if defined(__GLIBC__)
    ::mallopt(M_MMAP_THRESHOLD, 1 << 30);
    ::mallopt(M_TRIM_THRESHOLD, INT_MAX);
#endif
}

fresco::Value measured(const Network& network, const Room& room, bool reference, const MethodSettings& settings,
                       const std::filesystem::path& weights, Measure& measure)
{
    if (!reference)
    {
        keep_freed_memory();
        fresco::reuse_tensor_memory();
    }
    Studio studio(network, room, reference, settings, weights);
    Evaluator evaluator(studio.losses, ValueSpace(Values::network), torch::kCPU, 0, !reference);
    // The first step of a run sorts the filters and touches memory for the first time, either way.
    const double loss = studio.step(evaluator);
    const auto first = measure.times(1,
                                     [&]
                                     {
                                         forget_camera(studio.view);
                                         studio.step(evaluator);
                                     });
    const auto again = measure.times(2,
                                     [&]
                                     {
                                         if (reference)
                                             forget_camera(studio.view);
                                         studio.step(evaluator);
                                     });
    const auto mean = [&](double one, double other) { return reference ? other : (one + (repeats - 1) * other) / repeats; };
    std::int64_t seen = 0;
    for (const auto& level : studio.view.levels)
        for (const auto& gradient : level.view->gradient(at::zeros({3, level.camera.size(1), level.camera.size(2)})))
            seen += gradient.texels.numel();
    return fresco::Value::Map{{"seconds_per_step", mean(first.wall, again.wall)},
                              {"processor_seconds_per_step", mean(first.processor, again.processor)},
                              {"giga_multiply_adds", network_work(studio, network, reference) / 1e9},
                              {"texels_updated", reference ? studio.texels() : seen},
                              {"loss", loss}};
}

}  // namespace

Table step_table(const MethodSettings& settings, const std::filesystem::path& folder)
{
    Table table("steps",
                "a step of the paper's method at " + std::to_string(settings.step_size_px) +
                    "², heights 256 to 784 px: as texture.optimize runs it (10 steps a view), and as the released code does",
                {{"network", "VGG-19"},
                 {"levels", "levels"},
                 {"way", "way"},
                 {"giga_multiply_adds", "G multiply-adds forward", 1},
                 {"texels_updated", "texels updated"},
                 {"seconds_per_step", "s/step"},
                 {"processor_seconds_per_step", "cpu s/step"},
                 {"times_faster", "x faster (cpu)", 1},
                 {"process_mb", "peak MB", 0},
                 {"times_smaller", "x smaller", 1},
                 {"loss_difference", "loss apart", 7}});
    for (const auto& network : networks)
    {
        const auto weights = folder / (std::string(network.last) + ".safetensors");
        write_random_vgg19(weights, network.last);
        for (const auto& room : rooms)
        {
            fresco::Value reference;
            for (const bool is_reference : {true, false})
            {
                auto row =
                    run_case([&](Measure& measure) { return measured(network, room, is_reference, settings, weights, measure); });
                row.set("network", network.name);
                row.set("levels", room.levels);
                row.set("way", is_reference ? "reference" : "texture.optimize");
                if (is_reference)
                    reference = row;
                row.set("times_faster",
                        ratio(entry(reference, "processor_seconds_per_step"), entry(row, "processor_seconds_per_step")));
                row.set("times_smaller", ratio(entry(reference, "process_mb"), entry(row, "process_mb")));
                if (const auto own = entry(row, "loss"), other = entry(reference, "loss"); !own.is_null() && !other.is_null())
                    row.set("loss_difference", std::abs(own.as_double() / other.as_double() - 1));
                table.add(std::move(row));
            }
        }
    }
    return table;
}

}  // namespace bench
