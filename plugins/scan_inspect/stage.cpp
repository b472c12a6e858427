#include "diagnosis.h"
#include "drawing.h"
#include "views.h"
#include "wording.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

using namespace fresco;

namespace
{

/// Nearest neighbor: depths on both sides of a step must not mix.
RasterF sampled(const RasterF& depth, int width, int height)
{
    RasterF result(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            result.at(x, y) = depth.at((2 * x + 1) * depth.width / (2 * width), (2 * y + 1) * depth.height / (2 * height));
    return result;
}

class ScanInspect final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The room as scanned"};
    Input<Frames> frames{this, "frames", "The recorded frames"};
    Output<Files> pictures{this, "pictures", "A PNG that overlays mesh and frames, and the measurements as JSON"};
    Option<int> frames_count{this, "frames_count", 12, range(1, 10'000), "Number of frames to inspect, evenly spread"};
    Option<int> pictures_count{this, "pictures_count", 4, range(1, 64), "Number of inspected frames to draw"};
    Option<OutputName> path{this, "path", OutputName{"inspect.png"},
                            "File of the picture, below --out; the JSON file lies beside it"};
    Option<bool> fail{this, "fail", false, "End with an error instead of a warning if something is wrong"};
    Slot<ImageIo> images{this, "images", "image.opencv", "Reads and writes pictures"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 0.1, .per_face = 4e-7, .per_step = 0.03},
                .memory_mb = {.fixed = 60, .per_face = 1.2e-4, .per_step = 0.6},
                .disk_mb = {.fixed = 1},
                .steps = {.option = "frames_count"}};
    }

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        std::filesystem::path json = path->path;
        json.replace_extension(".json");
        if (json == path->path)
            throw Error("option \"path\": '" + path->path +
                        "' is the name of the JSON file beside the picture; use a name that ends in .png");
        const auto chosen = choose(static_cast<std::size_t>(*frames_count));
        const raycast::Scene scene(*mesh);
        std::vector<inspect::View> views;
        for (const std::size_t i : chosen)
        {
            run.check_canceled();
            views.push_back(inspect::view_of(frames->frames[i], *images.get()));
            run.progress(static_cast<double>(views.size()), static_cast<double>(chosen.size()), "frames");
        }
        const auto found = inspect::diagnose(scene, views, run);
        tell(found, run);

        const auto sheet = images->encode_png(inspect::draw(panels(scene, chosen, found, run)));
        Files result;
        result.names = {path->path, json.generic_string()};
        const auto folder = pictures.folder().path;
        std::filesystem::create_directories((folder / path->path).parent_path());
        write_file(folder / path->path, sheet);
        write_file(folder / json, to_json(figures(found, scene, views, chosen, run), 1) + "\n");
        if (*fail && !found.findings.empty())
        {
            const auto preview = run.preview_folder() / "inspect.png";
            write_file(preview, sheet);
            throw Error(found.findings.front().text + " (" + preview.string() + " shows it)");
        }
        pictures = std::move(result);
    }

    std::vector<std::size_t> choose(std::size_t count) const
    {
        const std::size_t all = frames->frames.size();
        if (all == 0)
            throw Error("port 'frames' has no frames: check the scan's path and the stages that drop frames");
        count = std::min(count, all);
        std::vector<std::size_t> chosen(count);
        for (std::size_t i = 0; i < count; ++i)
            chosen[i] = (2 * i + 1) * all / (2 * count);
        return chosen;
    }

    std::vector<inspect::Panel> panels(const raycast::Scene& scene, const std::vector<std::size_t>& chosen,
                                       const inspect::Diagnosis& found, RunContext& run) const
    {
        const auto count = std::min(static_cast<std::size_t>(*pictures_count), chosen.size());
        std::vector<inspect::Panel> all;
        for (std::size_t i = 0; i < count; ++i)
        {
            const Frame& frame = frames->frames[chosen[(2 * i + 1) * chosen.size() / (2 * count)]];
            all.push_back(panel(scene, frame, frame.color, frame.depth, 1, run));
            if (found.findings.empty())
                continue;
            const auto [color, depth] = inspect::explained_cameras(found, frame.color, frame.depth);
            all.push_back(panel(scene, frame, color, depth, found.depth_scale, run));
            all.back().suggested = true;
        }
        return all;
    }

    inspect::Panel panel(const raycast::Scene& scene, const Frame& frame, const Camera& color, const Camera& depth,
                         double depth_scale, RunContext& run) const
    {
        inspect::Panel result;
        if (!frame.color_picture.empty())
        {
            const Camera camera = inspect::at_height(color, inspect::panel_height_px);
            result.picture = resized(load_color(frame, images.get().get()), camera.intrinsics.width, camera.intrinsics.height);
            result.outlined = inspect::outline(inspect::mesh_depth(scene, camera, run));
        }
        if (!frame.depth_picture.empty())
        {
            const Camera camera = inspect::at_height(depth, inspect::panel_height_px);
            result.measured = sampled(load_depth(frame, images.get().get()), camera.intrinsics.width, camera.intrinsics.height);
            for (float& value : result.measured.values)
                value *= static_cast<float>(depth_scale);
            result.mesh = inspect::mesh_depth(scene, camera, run);
        }
        return result;
    }

    static Value agreement(const inspect::Agreement& figures)
    {
        return Value::Map{{"depth_share", figures.depth_share},
                          {"depth_seen_share", figures.depth_seen_share},
                          {"depth_median_error", figures.depth_median_error},
                          {"edge_response", figures.edge_response}};
    }

    Value figures(const inspect::Diagnosis& found, const raycast::Scene& scene, const std::vector<inspect::View>& views,
                  const std::vector<std::size_t>& chosen, const RunContext& run) const
    {
        Value::List findings;
        for (const auto& finding : found.findings)
            findings.emplace_back(Value::Map{{"cause", finding.cause}, {"text", finding.text}});
        Value::List looked_at;
        for (std::size_t i = 0; i < views.size(); ++i)
        {
            const Frame& frame = frames->frames[chosen[i]];
            const auto ratios = inspect::depth_ratios(scene, {views[i].depth}, {}, 1, 1, run);
            looked_at.emplace_back(Value::Map{{"sequence", frame.sequence},
                                              {"frame", frame.name},
                                              {"depths", ratios.ratios.size()},
                                              {"depth_share", ratios.share(1, 0.03)},
                                              {"depth_median_error", ratios.median_error(1)}});
        }
        return Value::Map{{"findings", std::move(findings)},         {"recorded", agreement(found.recorded)},
                          {"explained", agreement(found.explained)}, {"depths", found.depths},
                          {"outline_points", found.outline_points},  {"seen_share", found.seen_share},
                          {"front_share", found.front_share},        {"frames", std::move(looked_at)}};
    }

    void tell(const inspect::Diagnosis& found, RunContext& run) const
    {
        Value::List causes;
        for (const auto& finding : found.findings)
        {
            causes.emplace_back(finding.cause);
            run.warning(finding.text);
        }
        run.report("causes", causes);
        run.report("frames", std::min(frames->frames.size(), static_cast<std::size_t>(*frames_count)));
        run.report("depths", found.depths);
        run.report("depth_share", found.recorded.depth_share);
        run.report("depth_median_error", found.recorded.depth_median_error);
        run.report("edge_response", found.recorded.edge_response);
        run.report("depth_share_explained", found.explained.depth_share);
        run.report("edge_response_explained", found.explained.edge_response);
        run.message(inspect::summary(found));
    }
};

}  // namespace

FRESCO_STAGE("scan.inspect", ScanInspect, "Overlays mesh and frames, measures how well they agree and names the likely mistake")
FRESCO_LIBRARY("Embree", raycast::embree_version())
