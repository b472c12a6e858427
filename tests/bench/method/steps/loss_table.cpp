#include "components.h"
#include "forked_case.h"
#include "method_tables.h"
#include "scene.h"
#include "view_part.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>

namespace bench
{
namespace
{

using Losses = std::vector<std::shared_ptr<fresco::Loss>>;

/// As many as a visit of texture.optimize makes by default.
constexpr int steps_per_view = 8;

/// What a step does again although it need not.
enum class Again
{
    nothing,
    camera,           ///< Encodes the camera picture in every step.
    camera_and_image  ///< … and the image for every loss.
};

/// A picture that looks like neither camera nor style, as in the middle of a run.
struct View
{
    torch::Tensor camera;
    torch::Tensor start;

    explicit View(int height_px)
        : camera(fresco::to_tensor(generated_camera_picture(height_px * 4 / 3, height_px))),
          start(camera * 0.5 + fresco::to_tensor(generated_style(height_px * 4 / 3, height_px)) * 0.5)
    {
    }
};

struct Outcome
{
    double loss = 0;
    torch::Tensor gradient;
};

/// Losses of one picture and their gradient, as texture.optimize takes them.
Outcome one_step(const Losses& losses, const View& view, const Wanted& wanted, Encoded& kept, Again again, std::int64_t step)
{
    const auto image = view.start.detach().clone().set_requires_grad(true);
    if (again != Again::nothing)
        kept.forget();
    ViewPart shared(image, view.camera, kept, wanted, step);
    std::vector<std::unique_ptr<ViewPart>> parts;
    torch::Tensor sum;
    for (const auto& loss : losses)
    {
        if (again == Again::camera_and_image)
            parts.push_back(std::make_unique<ViewPart>(image, view.camera, kept, wanted, step));
        for (const auto& term : loss->evaluate(again == Again::camera_and_image ? *parts.back() : shared))
        {
            const auto weighted = term.value * *loss->weight;
            sum = sum.defined() ? sum + weighted : weighted;
        }
    }
    if (!sum.defined())
        throw fresco::Error("no loss has anything to say about the picture");
    return {sum.item<double>(), torch::autograd::grad({sum}, {image})[0]};
}

Outcome one_visit(const Losses& losses, const View& view, Again again)
{
    const auto wanted = wanted_layers(losses);
    Encoded kept;
    Outcome last;
    for (int step = 0; step < steps_per_view; ++step)
        last = one_step(losses, view, wanted, kept, again, step);
    return last;
}

Losses made(Components& components, const fresco::Value::List& configs)
{
    Losses losses;
    for (const auto& config : configs)
        losses.push_back(components.make<fresco::Loss>(config));
    return losses;
}

fresco::Value measured(const fresco::Value::List& configs, const MethodSettings& settings, Measure& measure)
{
    at::set_num_threads(settings.threads);
    Components components;
    const auto losses = made(components, configs);
    Measure preparing;
    const auto prepare_times = preparing.times(1, [&] { prepare(losses, settings.loss_height_px); });
    const View view(settings.loss_height_px);
    const auto times = measure.times(2, [&] { one_visit(losses, view, Again::nothing); });
    return fresco::Value::Map{{"prepare_seconds", prepare_times.wall},
                              {"ms_per_step", 1e3 * times.wall / steps_per_view},
                              {"processor_ms_per_step", 1e3 * times.processor / steps_per_view}};
}

/// All ways in one process, on the same prepared losses.
fresco::Value compared(const fresco::Value::List& configs, const MethodSettings& settings, Measure& measure)
{
    at::set_num_threads(settings.threads);
    Components components;
    const auto losses = made(components, configs);
    prepare(losses, settings.loss_height_px);
    const View view(settings.loss_height_px);
    const auto once = one_visit(losses, view, Again::nothing);
    double apart = 0;
    for (const auto again : {Again::camera, Again::camera_and_image})
    {
        const auto other = one_visit(losses, view, again);
        apart = std::max({apart, std::abs(other.loss - once.loss) / std::abs(once.loss),
                          ((other.gradient - once.gradient).abs().max() / once.gradient.abs().max()).item<double>()});
    }
    fresco::Value figures = fresco::Value::Map{{"relative_difference", apart}};
    for (const auto& [key, again] :
         {std::pair{"once_processor_ms", Again::nothing}, std::pair{"camera_again_processor_ms", Again::camera},
          std::pair{"all_again_processor_ms", Again::camera_and_image}})
        figures.set(key, 1e3 * measure.times(1, [&, way = again] { one_visit(losses, view, way); }).processor / steps_per_view);
    figures.set("camera_times", ratio(figures.at("camera_again_processor_ms"), figures.at("once_processor_ms")));
    figures.set("all_times", ratio(figures.at("all_again_processor_ms"), figures.at("once_processor_ms")));
    return figures;
}

fresco::Value vgg19_features(const std::filesystem::path& file)
{
    return fresco::Value::Map{{"type", "features.vgg19"}, {"weights", file.string()}};
}

fresco::Value loss(const char* type, fresco::Value features = {})
{
    fresco::Value config = fresco::Value::Map{{"type", type}};
    if (!features.is_null())
        config.set("features", std::move(features));
    return config;
}

}  // namespace

Table loss_table(const MethodSettings& settings, const std::filesystem::path& vgg19)
{
    Table table("losses", "value and gradient of one picture, mean of 8 steps on one view; VGG-19 up to conv4_2, random weights",
                {{"losses", "losses"},
                 {"features", "features"},
                 {"height_px", "height px"},
                 {"prepare_seconds", "prepare s"},
                 {"ms_per_step", "ms/step", 1},
                 {"processor_ms_per_step", "cpu ms/step", 1},
                 {"times_as_long", "x first (cpu)", 2},
                 {"peak_mb", "peak MB", 0}});
    struct Case
    {
        const char* losses;
        const char* features;
        fresco::Value::List configs;
    };
    const std::vector<Case> cases{
        {"patch_match", "pixels", {loss("loss.patch_match")}},
        {"gram", "vgg19", {loss("loss.gram", vgg19_features(vgg19))}},
        {"content", "vgg19", {loss("loss.content", vgg19_features(vgg19))}},
        {"gram + content", "vgg19", {loss("loss.gram", vgg19_features(vgg19)), loss("loss.content", vgg19_features(vgg19))}}};
    fresco::Value first;
    for (const auto& one : cases)
    {
        auto row = run_case([&](Measure& measure) { return measured(one.configs, settings, measure); });
        row.set("losses", one.losses);
        row.set("features", one.features);
        row.set("height_px", settings.loss_height_px);
        if (first.is_null())
            first = entry(row, "processor_ms_per_step");
        row.set("times_as_long", ratio(entry(row, "processor_ms_per_step"), first));
        table.add(std::move(row));
    }
    return table;
}

Table features_table(const MethodSettings& settings, const std::filesystem::path& vgg19)
{
    Table table("features", "gram + content: pictures encoded once per view, or the camera's and the image's again and again",
                {{"features", "features"},
                 {"height_px", "height px"},
                 {"once_processor_ms", "once: cpu ms/step", 1},
                 {"camera_again_processor_ms", "camera again: cpu ms/step", 1},
                 {"camera_times", "x once"},
                 {"all_again_processor_ms", "image per loss too: cpu ms/step", 1},
                 {"all_times", "x once"},
                 {"relative_difference", "apart", 7}});
    const auto features = vgg19_features(vgg19);
    const fresco::Value::List configs{loss("loss.gram", features), loss("loss.content", features)};
    auto row = run_case([&](Measure& measure) { return compared(configs, settings, measure); });
    row.set("features", "vgg19");
    row.set("height_px", settings.loss_height_px);
    table.add(std::move(row));
    return table;
}

}  // namespace bench
