// Judges paintings on views that the optimiser has not seen: how much of the way from the camera picture to the style, by
// VGG-19's Gram matrices, beside what recolouring alone does; how far the room's edges are still there. Draws the sheet style |
// camera | render.
#include "measures.h"

#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/recolour.h>

#include <ATen/ATen.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace
{

namespace fs = std::filesystem;

constexpr int measured_px = 256;

struct Settings
{
    std::string scan;
    std::string weights;
    std::vector<std::string> styles;
    std::vector<std::string> views;
    std::string sheet = "contact_sheet.png";
    std::string json;
    int shown = 3;
};

struct View
{
    std::string name;
    torch::Tensor camera;
    torch::Tensor render;
};

struct Figures
{
    double recoloured = 0;
    double render = 0;
    double edges = 0;
    double edges_lowest = 1;
};

std::shared_ptr<fresco::FeatureNetwork> measuring_network(const std::string& weights)
{
    fresco::testing::TestFactory factory;
    factory.add("features.vgg19",
                []
                {
                    const auto file = fs::path(FRESCO_PLUGIN_FOLDER) / "features_vgg19.so";
                    auto made = fresco::testing::make_from_plugin(file, "features.vgg19");
                    return std::shared_ptr<fresco::Component>(dynamic_cast<fresco::Component*>(made.release()));
                });
    auto network = std::dynamic_pointer_cast<fresco::FeatureNetwork>(
        factory.create("features", fresco::Value::Map{{"type", "features.vgg19"}, {"weights", weights}}));
    fresco::Progress progress;
    fresco::PrepareContext context;
    context.progress = &progress;
    network->prepare(context);
    return network;
}

/// views/<sequence>_<frame>.png and the scan's <sequence>/frame-<frame>.color.jpg, at the size that is measured.
std::vector<View> read_views(const Settings& settings, const std::string& folder)
{
    std::vector<View> views;
    for (const auto& entry : fs::directory_iterator(folder))
    {
        const auto name = entry.path().stem().string();
        const auto split = name.rfind("_frame-");
        if (entry.path().extension() != ".png" || split == std::string::npos)
            continue;
        const auto frame = fs::path(settings.scan) / name.substr(0, split) / (name.substr(split + 1) + ".color.jpg");
        const auto camera = bench::read_picture(frame.string(), 0, false);
        views.push_back({name, bench::resized(camera, measured_px),
                         bench::resized(bench::read_over(entry.path().string(), camera), measured_px)});
    }
    if (views.empty())
        throw fresco::MissingInput(folder + ": holds no rendered view");
    std::sort(views.begin(), views.end(), [](const View& a, const View& b) { return a.name < b.name; });
    return views;
}

Figures measure(const fresco::FeatureNetwork& network, const torch::Tensor& style, const std::vector<View>& views)
{
    fresco::ColorMoments colours;
    for (const auto& view : views)
        colours.add(fresco::color_moments(view.camera));
    const auto map = fresco::monge_kantorovich(colours, fresco::color_moments(style));
    const auto style_grams = bench::grams(network, style);
    Figures figures;
    for (const auto& view : views)
    {
        const auto camera_grams = bench::grams(network, view.camera);
        figures.recoloured +=
            bench::relative_distance(bench::grams(network, fresco::recoloured(view.camera, map)), style_grams, camera_grams);
        figures.render += bench::relative_distance(bench::grams(network, view.render), style_grams, camera_grams);
        const double edges = bench::edge_correlation(view.camera, view.render);
        figures.edges += edges;
        figures.edges_lowest = std::min(figures.edges_lowest, edges);
    }
    const auto count = static_cast<double>(views.size());
    figures.recoloured /= count;
    figures.render /= count;
    figures.edges /= count;
    return figures;
}

void judge(const Settings& settings)
{
    if (settings.styles.size() != settings.views.size())
        throw fresco::Error("every --style needs its own --views");
    const auto network = measuring_network(settings.weights);
    std::vector<std::vector<torch::Tensor>> rows;
    auto report = nlohmann::json::array();
    std::printf("%-24s %10s %10s %12s %12s %8s %8s\n", "style", "views", "recoloured", "render", "of recolour", "edges",
                "lowest");
    for (std::size_t i = 0; i < settings.styles.size(); ++i)
    {
        const auto style = bench::read_picture(settings.styles[i], measured_px, false);
        const auto views = read_views(settings, settings.views[i]);
        const auto figures = measure(*network, style, views);
        const auto name = fs::path(settings.styles[i]).stem().string();
        std::printf("%-24s %10zu %10.3f %12.3f %12.3f %8.3f %8.3f\n", name.c_str(), views.size(), figures.recoloured,
                    figures.render, figures.render / figures.recoloured, figures.edges, figures.edges_lowest);
        std::fflush(stdout);
        report.push_back({{"style", name},
                          {"views", views.size()},
                          {"recoloured", figures.recoloured},
                          {"render", figures.render},
                          {"share_of_recoloured", figures.render / figures.recoloured},
                          {"edges", figures.edges},
                          {"edges_lowest", figures.edges_lowest}});
        auto& row = rows.emplace_back();
        row.push_back(style);
        const auto shown = std::min(views.size(), static_cast<std::size_t>(settings.shown));
        for (std::size_t k = 0; k < shown; ++k)
        {
            const auto& view = views[k * views.size() / shown];
            row.push_back(view.camera);
            row.push_back(view.render);
        }
    }
    bench::write_sheet(settings.sheet, rows);
    if (!settings.json.empty())
        std::ofstream(settings.json) << report.dump(2) << '\n';
}

}  // namespace

int main(int argc, char** argv)
{
    Settings settings;
    CLI::App app{"Judges rendered views of frames that were held out, and draws the sheet style | camera | render"};
    app.add_option("--scan", settings.scan, "The scan's folder (layout of 7-Scenes)")->required()->check(CLI::ExistingDirectory);
    app.add_option("--weights", settings.weights, "VGG-19 as safetensors")->required()->check(CLI::ExistingFile);
    app.add_option("--style", settings.styles, "Style picture; once for every --views")->required();
    app.add_option("--views", settings.views, "Folder that render.views wrote")->required();
    app.add_option("--sheet", settings.sheet, "The sheet's file");
    app.add_option("--json", settings.json, "Figures as JSON");
    app.add_option("--shown", settings.shown, "Views a row")->check(CLI::Range(1, 100));
    CLI11_PARSE(app, argc, argv);
    try
    {
        judge(settings);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
