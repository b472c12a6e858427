// Stylises one camera picture with a set of losses, its pixels as unknowns, and says how near it comes to the style by VGG-19's
// Gram matrices relative to the camera picture. For choosing losses and weights without waiting for a room.
#include "measures.h"

#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/recolour.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace
{

struct Settings
{
    std::string frame;
    std::vector<std::string> samples;
    std::vector<std::string> styles;
    std::string weights;
    std::string out = ".";
    std::string name = "default";
    std::string losses =
        R"({"style": {"type": "loss.gram"}, "strokes": {"type": "loss.patch_match", "weight": 3},
            "content": {"type": "loss.content_gradients", "weight": 0.1}})";
    int height_px = 256;
    int steps = 150;
    int threads = 1;
    double rate = 0.02;
};

/// Processor time, all threads together: what a step costs does not depend on what else runs.
double processor_seconds()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Components from the build's plugins: type a.b is in a_b.so.
class Plugins
{
  public:
    Plugins()
    {
        for (const char* type : {"loss.gram", "loss.content", "loss.content_gradients", "loss.patch_match"})
            factory_.add(type, [type] { return make(type); });
        for (const char* type : {"features.dictionary", "features.vgg19"})
            factory_.add(type,
                         [this, type]
                         {
                             auto made = make(type);
                             networks.push_back(std::dynamic_pointer_cast<fresco::FeatureNetwork>(made));
                             return made;
                         });
    }

    std::shared_ptr<fresco::Component> create(const char* kind, const fresco::Value& config)
    {
        return factory_.create(kind, config);
    }

    std::vector<std::shared_ptr<fresco::FeatureNetwork>> networks;

  private:
    static std::shared_ptr<fresco::Component> make(const std::string& type)
    {
        std::string file = type;
        file[file.find('.')] = '_';
        auto made = fresco::testing::make_from_plugin(std::filesystem::path(FRESCO_PLUGIN_FOLDER) / (file + ".so"), type);
        return std::shared_ptr<fresco::Component>(dynamic_cast<fresco::Component*>(made.release()));
    }

    fresco::testing::TestFactory factory_;
};

/// Adam with betas 0.9 and 0.99, values kept in [0,1].
class Adam
{
  public:
    explicit Adam(const torch::Tensor& values) : first_(at::zeros_like(values)), second_(at::zeros_like(values)) {}

    void step(torch::Tensor& values, const torch::Tensor& gradient, double rate)
    {
        ++count_;
        first_.mul_(0.9).add_(gradient, 0.1);
        second_.mul_(0.99).addcmul_(gradient, gradient, 0.01);
        const auto deviation = (second_ / (1 - std::pow(0.99, count_))).sqrt_().add_(1e-8);
        values.sub_(first_ / (1 - std::pow(0.9, count_)) / deviation * rate).clamp_(0, 1);
    }

  private:
    torch::Tensor first_;
    torch::Tensor second_;
    int count_ = 0;
};

using Losses = std::map<std::string, std::shared_ptr<fresco::Loss>>;

torch::Tensor optimise(const Settings& settings, Losses& losses, const torch::Tensor& camera, const torch::Tensor& start)
{
    auto picture = start.clone();
    Adam adam(picture);
    std::map<std::string, double> seconds;
    for (int step = 0; step < settings.steps; ++step)
    {
        auto variable = picture.detach().requires_grad_();
        fresco::testing::PicturePart part(variable, camera);
        part.step_index = step;
        part.repeat_index = step;
        auto gradient = at::zeros_like(picture);
        std::string line;
        for (auto& [name, loss] : losses)
        {
            const double begin = processor_seconds();
            torch::Tensor sum;
            for (const auto& term : loss->evaluate(part))
                sum = sum.defined() ? sum + term.value : term.value;
            variable.mutable_grad() = torch::Tensor();
            sum.backward({}, true);
            gradient.add_(variable.grad(), *loss->weight);
            seconds[name] += processor_seconds() - begin;
            if (step % 25 == 0 || step + 1 == settings.steps)
                line += "  " + name + " " + std::to_string(sum.item<double>()) + " |g| " +
                        std::to_string(*loss->weight * variable.grad().pow(2).mean().sqrt().item<double>() * 1e6);
        }
        if (!line.empty())
            std::printf("    step %d%s\n", step, line.c_str());
        const double half = settings.steps / 2.0;
        const double decay = step < half ? 1 : 0.5 + 0.5 * std::cos(std::numbers::pi * (step - half) / half);
        adam.step(picture, gradient, settings.rate * std::max(decay, 0.02));
    }
    for (const auto& [name, total] : seconds)
        std::printf("    %s: %.3f s a step\n", name.c_str(), total / settings.steps);
    return picture;
}

void stylise(const Settings& settings, const std::string& style_file)
{
    Plugins plugins;
    const auto measuring = std::dynamic_pointer_cast<fresco::FeatureNetwork>(
        plugins.create("features", fresco::Value::Map{{"type", "features.vgg19"}, {"weights", settings.weights}}));
    Losses losses;
    const auto configs = fresco::parse_json(settings.losses, "--losses");
    for (const auto& [name, config] : configs.as_map())
        losses[name] = std::dynamic_pointer_cast<fresco::Loss>(plugins.create("loss", config));

    fresco::Progress progress;
    fresco::PrepareContext context;
    context.progress = &progress;
    context.style.fine = bench::read_picture(style_file, 256, false);
    context.style.coarse = bench::read_picture(style_file, 1024, false);
    const auto camera = bench::read_picture(settings.frame, settings.height_px, true);
    context.camera_samples = {camera};
    for (const auto& sample : settings.samples)
        context.camera_samples.push_back(bench::read_picture(sample, settings.height_px, true));
    double begin = processor_seconds();
    for (const auto& network : plugins.networks)
        network->prepare(context);
    const double learned = processor_seconds();
    for (auto& [name, loss] : losses)
        loss->prepare(context);
    const double prepared = processor_seconds();

    fresco::ColorMoments colours;
    for (const auto& sample : context.camera_samples)
        colours.add(fresco::color_moments(sample));
    const auto start = fresco::recoloured(camera, fresco::monge_kantorovich(colours, fresco::color_moments(context.style.fine)));
    const auto name = std::filesystem::path(style_file).stem().string();
    std::printf("  %s: networks %.2f s, losses %.2f s\n", name.c_str(), learned - begin, prepared - learned);
    begin = processor_seconds();
    const auto result = optimise(settings, losses, camera, start);
    const double seconds = (processor_seconds() - begin) / settings.steps;

    const auto style_grams = bench::grams(*measuring, context.style.fine);
    const auto camera_grams = bench::grams(*measuring, camera);
    const double recoloured = bench::relative_distance(bench::grams(*measuring, start), style_grams, camera_grams);
    const double reached = bench::relative_distance(bench::grams(*measuring, result), style_grams, camera_grams);
    std::printf("%-10s %-14s recoloured %.3f  result %.3f  of recoloured %.3f  edges %.3f (recoloured %.3f)  %.3f s a step\n",
                settings.name.c_str(), name.c_str(), recoloured, reached, reached / recoloured,
                bench::edge_correlation(camera, result), bench::edge_correlation(camera, start), seconds);
    std::fflush(stdout);
    bench::write_picture((std::filesystem::path(settings.out) / (settings.name + "_" + name + ".png")).string(),
                         {context.style.fine, start, result});
}

}  // namespace

int main(int argc, char** argv)
{
    Settings settings;
    CLI::App app{"Stylises one picture with a set of losses and measures the result"};
    app.add_option("--frame", settings.frame, "Camera picture")->required();
    app.add_option("--sample", settings.samples, "More camera pictures for the colours");
    app.add_option("--style", settings.styles, "Style pictures")->required();
    app.add_option("--weights", settings.weights, "VGG-19 as safetensors, for measuring")->required();
    app.add_option("--out", settings.out, "Folder for the pictures");
    app.add_option("--name", settings.name, "First part of their names");
    app.add_option("--losses", settings.losses, "JSON map of losses");
    app.add_option("--height", settings.height_px, "Height of the picture in pixels");
    app.add_option("--steps", settings.steps, "Steps of Adam");
    app.add_option("--threads", settings.threads, "Threads of libtorch");
    app.add_option("--rate", settings.rate, "Learning rate");
    CLI11_PARSE(app, argc, argv);
    try
    {
        at::set_num_threads(settings.threads);
        for (const auto& style : settings.styles)
            stylise(settings, style);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
