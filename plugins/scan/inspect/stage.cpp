#include "drawing.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/inspection/diagnosis.h>
#include <fresco/inspection/views.h>
#include <fresco/inspection/wording.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

using namespace fresco;

namespace
{

constexpr std::size_t most_pictures = 4;

class ScanInspect final : public Stage
{
    Input<Mesh> mesh{this, "mesh", optional, "The room as scanned; without it, frames are compared with each other"};
    Input<Frames> frames{this, "frames", "The recorded frames"};
    Output<Files> pictures{this, "pictures", "A PNG of what was compared, and the measurements as JSON"};
    Option<int> frames_count{this, "frames_count", 12, range(1, 10'000),
                             "Number of frames to inspect, evenly spread; without a mesh, in groups of four"};
    Option<OutputName> path{this, "path", OutputName{"inspect.png"}, extensions({".png"}),
                            "File of the picture, below --out; the JSON file lies beside it"};
    Option<bool> fail{this, "fail", false, "End with an error if a mistake is certain"};
    Slot<ImageIo> images{this, "Reads and writes pictures"};

    void run(RunContext& run) override
    {
        std::optional<raycast::Scene> cast;
        if (mesh.has_value())
        {
            check_mesh(*mesh, "the mesh on port 'mesh'");
            check_offset(*frames, *mesh);
            cast.emplace(*mesh);
        }
        const raycast::Scene* const scene = cast ? &*cast : nullptr;
        std::filesystem::path json = path->path;
        json.replace_extension(".json");
        if (frames->frames.empty())
            throw Error("port 'frames' has no frames: check the scan's path and the stages that drop frames");
        const auto depth = [&](const Frame& frame) { return load_depth(frame, images.get().get()); };
        const auto chosen = inspect::chosen_frames(*frames, static_cast<std::size_t>(*frames_count), mesh.has_value(), depth);
        std::vector<inspect::View> views;
        for (const inspect::Chosen& one : chosen)
        {
            run.check_canceled();
            views.push_back(inspect::view_of(*frames, one, depth, images.get().get()));
            run.progress(static_cast<double>(views.size()), static_cast<double>(chosen.size()), "frames");
        }
        const auto found = inspect::diagnose(scene, views, run);
        tell(found, views.size(), run);

        const auto sheet = images->encode_png(inspect::draw(panels(scene, views, found, run)));
        Files result;
        result.names = {path->path, json.generic_string()};
        const auto folder = pictures.folder().path;
        std::filesystem::create_directories((folder / path->path).parent_path());
        write_file(folder / path->path, sheet);
        write_file(folder / json, to_json(figures(found, scene, views), 1) + "\n");
        const auto certain = std::ranges::find_if(found.findings, [](const auto& finding) { return finding.certain; });
        if (*fail && certain != found.findings.end())
        {
            const auto preview = run.preview_folder() / "inspect.png";
            write_file(preview, sheet);
            throw Error(certain->text + " (" + preview.string() + " shows it)");
        }
        pictures = std::move(result);
    }

    std::vector<inspect::Panel> panels(const raycast::Scene* scene, const std::vector<inspect::View>& views,
                                       const inspect::Diagnosis& found, RunContext& run) const
    {
        const auto count = std::min(most_pictures, views.size());
        std::vector<inspect::Panel> all;
        for (std::size_t i = 0; i < count; ++i)
        {
            const std::size_t place = (2 * i + 1) * views.size() / (2 * count);
            all.push_back(panel(scene, place, views, {}, run));
            if (!found.explains())
                continue;
            all.push_back(panel(scene, place, views, found, run));
            all.back().suggested = true;
        }
        return all;
    }

    /// Depth of the mesh, or without one of another frame of the group, as seen from this frame.
    RasterF compared(const raycast::Scene* scene, const Camera& camera, std::size_t place,
                     const std::vector<inspect::View>& views, const inspect::Diagnosis& assumed, RunContext& run) const
    {
        if (scene != nullptr)
            return inspect::mesh_depth(*scene, camera, run);
        for (const std::size_t other : {place + 1, place - 1})
            if (other < views.size() && views[other].depth.group == views[place].depth.group &&
                !views[other].depth.samples.empty())
            {
                RasterF measured = load_depth(frames->frames[views[other].frame], images.get().get());
                inspect::correct_depth(assumed, views[other], measured);
                return inspect::seen_from(camera, inspect::explained_cameras(assumed, views[other]).second, measured);
            }
        return RasterF(camera.intrinsics.width, camera.intrinsics.height);
    }

    inspect::Panel panel(const raycast::Scene* scene, std::size_t place, const std::vector<inspect::View>& views,
                         const inspect::Diagnosis& assumed, RunContext& run) const
    {
        const inspect::View& view = views[place];
        const Frame& frame = frames->frames[view.frame];
        const auto [color, depth] = inspect::explained_cameras(assumed, view);
        inspect::Panel result;
        if (!frame.color_picture.empty())
        {
            const Camera camera = inspect::at_height(color, inspect::panel_height_px);
            result.picture = resized(load_color(frame, images.get().get()), camera.intrinsics.width, camera.intrinsics.height);
            result.outlined = inspect::outline(compared(scene, camera, place, views, assumed, run), scene != nullptr);
        }
        if (!frame.depth_picture.empty())
        {
            const Camera camera = inspect::at_height(depth, inspect::panel_height_px);
            RasterF measured = load_depth(frame, images.get().get());
            inspect::correct_depth(assumed, view, measured);
            result.measured = inspect::nearest_sampled(measured, camera.intrinsics.width, camera.intrinsics.height);
            result.mesh = compared(scene, camera, place, views, assumed, run);
        }
        return result;
    }

    static Value figures(const inspect::Fit& fit)
    {
        return Value::Map{{"covered_share", fit.covered_share},     {"agreement", fit.agreement},
                          {"mesh_in_front_share", fit.in_front},    {"mesh_behind_share", fit.behind},
                          {"depth_median_error", fit.median_error}, {"edge_response", fit.edge_response}};
    }

    Value figures(const inspect::Diagnosis& found, const raycast::Scene* scene, const std::vector<inspect::View>& views) const
    {
        Value::List findings;
        for (const auto& finding : found.findings)
            findings.emplace_back(Value::Map{{"cause", finding.cause}, {"text", finding.text}, {"certain", finding.certain}});
        std::vector<inspect::DepthView> depths;
        for (const auto& view : views)
            depths.push_back(view.depth);
        const auto ratios = inspect::depth_ratios(scene, depths, {}, 1);
        const auto sums = inspect::agreement(ratios, 1);
        Value::List looked_at;
        for (std::size_t i = 0; i < views.size(); ++i)
        {
            const Frame& frame = frames->frames[views[i].frame];
            looked_at.emplace_back(Value::Map{{"sequence", frame.sequence},
                                              {"frame", frame.name},
                                              {"depths", depths[i].samples.size()},
                                              {"covered_share", sums[i].covered_share()},
                                              {"agreement", sums[i].share()},
                                              {"depth_median_error", inspect::median_error({ratios[i]}, 1)}});
        }
        return Value::Map{{"findings", std::move(findings)},        {"recorded", figures(found.recorded)},
                          {"explained", figures(found.explained)},  {"depths", found.depths},
                          {"outline_points", found.outline_points}, {"front_share", found.front_share},
                          {"frames", std::move(looked_at)}};
    }

    void tell(const inspect::Diagnosis& found, std::size_t inspected, RunContext& run) const
    {
        Value::List causes;
        for (const auto& finding : found.findings)
        {
            causes.emplace_back(finding.cause);
            run.warning(finding.text);
        }
        run.report("causes", causes);
        run.report("frames", inspected);
        run.report("depths", found.depths);
        run.report("covered_share", found.recorded.covered_share);
        run.report("agreement", found.recorded.agreement);
        run.report("agreement_explained", found.explained.agreement);
        run.report("depth_median_error", found.recorded.median_error);
        run.report("edge_response", found.recorded.edge_response);
        run.report("edge_response_explained", found.explained.edge_response);
        run.message(inspect::summary(found, mesh.has_value()));
    }
};

}  // namespace

FRESCO_STAGE("scan.inspect", ScanInspect,
             "Measures how well frames agree with a mesh or with each other and names the likely mistake")
FRESCO_LIBRARY("Embree", raycast::embree_version())
