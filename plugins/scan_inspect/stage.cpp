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
#include <vector>

using namespace fresco;

namespace
{

class ScanInspect final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The room as scanned"};
    Input<Frames> frames{this, "frames", "The recorded frames"};
    Output<Files> pictures{this, "pictures", "A PNG that overlays mesh and frames, and the measurements as JSON"};
    Option<int> frames_count{this, "frames_count", 12, range(1, 10'000), "Number of frames to inspect, evenly spread"};
    Option<int> pictures_count{this, "pictures_count", 4, range(1, 64), "Number of inspected frames to draw"};
    Option<OutputName> path{this, "path", OutputName{"inspect.png"}, extensions({".png"}),
                            "File of the picture, below --out; the JSON file lies beside it"};
    Option<bool> fail{this, "fail", false, "End with an error if a mistake is certain"};
    Slot<ImageIo> images{this, "images", "image.opencv", "Reads and writes pictures"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 0.1, .per = {{count::faces, 4e-7}}, .per_step = 0.03},
                .memory_mb = {.fixed = 60, .per = {{count::faces, 1.2e-4}}, .per_step = 0.6},
                .disk_mb = {.fixed = 1},
                .steps = {.option = "frames_count"}};
    }

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        std::filesystem::path json = path->path;
        json.replace_extension(".json");
        const auto chosen = choose(static_cast<std::size_t>(*frames_count));
        const raycast::Scene scene(*mesh);
        std::vector<inspect::View> views;
        for (const std::size_t i : chosen)
        {
            run.check_canceled();
            views.push_back(inspect::view_of(*frames, i, *images.get()));
            run.progress(static_cast<double>(views.size()), static_cast<double>(chosen.size()), "frames");
        }
        const auto found = inspect::diagnose(scene, views, run);
        tell(found, run);

        const auto sheet = images->encode_png(inspect::draw(panels(scene, views, chosen, found, run)));
        Files result;
        result.names = {path->path, json.generic_string()};
        const auto folder = pictures.folder().path;
        std::filesystem::create_directories((folder / path->path).parent_path());
        write_file(folder / path->path, sheet);
        write_file(folder / json, to_json(figures(found, scene, views, chosen), 1) + "\n");
        const auto certain = std::ranges::find_if(found.findings, [](const auto& finding) { return finding.certain; });
        if (*fail && certain != found.findings.end())
        {
            const auto preview = run.preview_folder() / "inspect.png";
            write_file(preview, sheet);
            throw Error(certain->text + " (" + preview.string() + " shows it)");
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

    std::vector<inspect::Panel> panels(const raycast::Scene& scene, const std::vector<inspect::View>& views,
                                       const std::vector<std::size_t>& chosen, const inspect::Diagnosis& found,
                                       RunContext& run) const
    {
        const auto count = std::min(static_cast<std::size_t>(*pictures_count), chosen.size());
        std::vector<inspect::Panel> all;
        for (std::size_t i = 0; i < count; ++i)
        {
            const std::size_t place = (2 * i + 1) * chosen.size() / (2 * count);
            const Frame& frame = frames->frames[chosen[place]];
            all.push_back(panel(scene, frame, views[place], {}, run));
            if (!found.explains())
                continue;
            all.push_back(panel(scene, frame, views[place], found, run));
            all.back().suggested = true;
        }
        return all;
    }

    inspect::Panel panel(const raycast::Scene& scene, const Frame& frame, const inspect::View& view,
                         const inspect::Diagnosis& assumed, RunContext& run) const
    {
        const auto [color, depth] = inspect::explained_cameras(assumed, view);
        inspect::Panel result;
        if (!frame.color_picture.empty())
        {
            const Camera camera = inspect::at_height(color, inspect::panel_height_px);
            result.picture = resized(load_color(frame, images.get().get()), camera.intrinsics.width, camera.intrinsics.height);
            if (assumed.color_change.upside_down)
                turn(result.picture);
            result.outlined = inspect::outline(inspect::mesh_depth(scene, camera, run), true);
        }
        if (!frame.depth_picture.empty())
        {
            const Camera camera = inspect::at_height(depth, inspect::panel_height_px);
            RasterF measured = load_depth(frame, images.get().get());
            inspect::correct_depth(assumed, view, measured);
            result.measured = inspect::nearest_sampled(measured, camera.intrinsics.width, camera.intrinsics.height);
            result.mesh = inspect::mesh_depth(scene, camera, run);
        }
        return result;
    }

    static void turn(Raster8& picture)
    {
        Raster8 turned = picture;
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x)
                for (int c = 0; c < picture.channels; ++c)
                    turned.at(picture.width - 1 - x, picture.height - 1 - y, c) = picture.at(x, y, c);
        picture = std::move(turned);
    }

    static Value figures(const inspect::Fit& fit)
    {
        return Value::Map{{"covered_share", fit.covered_share},     {"agreement", fit.agreement},
                          {"mesh_in_front_share", fit.in_front},    {"mesh_behind_share", fit.behind},
                          {"depth_median_error", fit.median_error}, {"edge_response", fit.edge_response}};
    }

    Value figures(const inspect::Diagnosis& found, const raycast::Scene& scene, const std::vector<inspect::View>& views,
                  const std::vector<std::size_t>& chosen) const
    {
        Value::List findings;
        for (const auto& finding : found.findings)
            findings.emplace_back(Value::Map{{"cause", finding.cause}, {"text", finding.text}, {"certain", finding.certain}});
        Value::List looked_at;
        for (std::size_t i = 0; i < views.size(); ++i)
        {
            const Frame& frame = frames->frames[chosen[i]];
            const auto ratios = inspect::depth_ratios(scene, {views[i].depth}, {}, 1);
            const auto sum = inspect::total(inspect::agreement(ratios, 1));
            looked_at.emplace_back(Value::Map{{"sequence", frame.sequence},
                                              {"frame", frame.name},
                                              {"depths", views[i].depth.samples.size()},
                                              {"covered_share", sum.covered_share()},
                                              {"agreement", sum.share()},
                                              {"depth_median_error", inspect::median_error(ratios, 1)}});
        }
        return Value::Map{{"findings", std::move(findings)},        {"recorded", figures(found.recorded)},
                          {"explained", figures(found.explained)},  {"depths", found.depths},
                          {"outline_points", found.outline_points}, {"front_share", found.front_share},
                          {"frames", std::move(looked_at)}};
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
        run.report("covered_share", found.recorded.covered_share);
        run.report("agreement", found.recorded.agreement);
        run.report("agreement_explained", found.explained.agreement);
        run.report("depth_median_error", found.recorded.median_error);
        run.report("edge_response", found.recorded.edge_response);
        run.report("edge_response_explained", found.explained.edge_response);
        run.message(inspect::summary(found));
    }
};

}  // namespace

FRESCO_STAGE("scan.inspect", ScanInspect, "Overlays mesh and frames, measures how well they agree and names the likely mistake")
FRESCO_LIBRARY("Embree", raycast::embree_version())
