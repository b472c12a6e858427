#include "pair_figures.h"

#include <fresco/evaluation/posed_pictures.h>
#include <fresco/evaluation/statistics.h>
#include <fresco/image_io.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/stage.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <utility>

using namespace fresco;
using evaluation::PosedPicture;

namespace
{

/// Keeps the most recent views within a budget of memory, because pairs share frames. Single-threaded.
class ViewCache
{
  public:
    using Loader = std::function<JudgedView(std::size_t)>;
    explicit ViewCache(Loader load) : load_(std::move(load)) {}

    std::shared_ptr<const JudgedView> get(std::size_t view)
    {
        for (auto entry = views_.begin(); entry != views_.end(); ++entry)
            if (entry->first == view)
            {
                views_.splice(views_.begin(), views_, entry);
                return views_.front().second;
            }
        views_.emplace_front(view, std::make_shared<const JudgedView>(load_(view)));
        const std::size_t bytes = views_.front().second->surface.depth.values.size() * bytes_per_pixel;
        while (views_.size() > 2 && views_.size() * bytes > budget_bytes)
            views_.pop_back();
        return views_.front().second;
    }

  private:
    static constexpr std::size_t bytes_per_pixel = 12;
    static constexpr std::size_t budget_bytes = std::size_t{256} << 20U;

    Loader load_;
    std::list<std::pair<std::size_t, std::shared_ptr<const JudgedView>>> views_;
};

/// A gap's name and the pairs it has.
struct Gap
{
    std::string name;
    long length = 0;
    std::vector<FramePair> pairs;
    std::size_t without_target = 0;  ///< Pictures.
    std::vector<PairFigures> figures;
};

class EvaluateReprojection final : public Stage
{
    Input<Files> views{this, "views", optional, "Pictures to judge, as render.views makes them: <sequence>_<frame>.png"};
    Input<Frames> frames{this, "frames", "The frames whose color cameras took the pictures; their own pictures are not read"};
    Input<TexturedMesh> textured_mesh{this, "textured_mesh", optional, "The mesh that 'views' shows, with its picture"};
    Input<Mesh> mesh{this, "mesh", optional, "The room's mesh, if there is no textured one"};
    Output<Files> figures{this, "figures", "All figures and every pair as JSON"};
    Option<InputFolder> folder{this, "folder", InputFolder{},
                               "Folder of pictures made elsewhere (<sequence>_<frame>.png or .jpg), instead of port 'views'"};
    Option<std::vector<int>> gaps{
        this, "gaps", {2, 20}, range(1, 1'000'000), "Recorded numbers from source to target, the short and the long range"};
    Option<int> every{this, "every", 1, range(1, 1'000'000),
                      "Measure only the pairs of every n-th picture; skipped pictures still serve as targets"};
    Option<double> min_covisible{this, "min_covisible", 0.2, range(0, 1),
                                 "Drop and count pairs with a smaller share of co-visible pixels"};
    Option<std::string> floor{
        this, "floor", "auto", one_of({"auto", "texture", "picture"}),
        "Floor from the mesh's texture or the source picture; auto: texture if views and textured_mesh are set"};
    Option<std::string> shading = rendering::shading_option(
        this, "Shading of 'views', as in render.views; applied to the floor of the mesh's picture, too");
    Option<OutputName> path{this, "path", OutputName{"reprojection.json"}, "Name of the JSON file, below --out"};
    Slot<ImageIo> images{this, "Reads the pictures"};

    /// Empty: the floor is that of the source picture.
    SurfacePaint floor_paint() const
    {
        if (*floor == "picture" || (*floor == "auto" && !(views.has_value() && textured_mesh.has_value())))
            return {};
        if (!textured_mesh.has_value() || textured_mesh->mesh.texcoords.empty())
            throw Error(
                "floor: texture needs a mesh with texcoords and a picture on port 'textured_mesh'; choose floor: picture");
        return texture_paint(*textured_mesh, rendering::lights_of(*shading));
    }

    JudgedView load_view(const PosedPicture& posed, const raycast::Scene& scene, const Progress& progress) const
    {
        Raster8 picture = images->read_rgb(posed.file);
        const Camera camera =
            evaluation::camera_of_picture(frames->frames[posed.frame], picture.width, picture.height, posed.file);
        return {view_surface(scene, camera, progress), std::move(picture)};
    }

    std::array<Gap, 2> paired(const std::vector<PosedPicture>& pictures) const
    {
        std::vector<FramePlace> places;
        for (const PosedPicture& picture : pictures)
            places.push_back({frames->frames[picture.frame].sequence, frames->frames[picture.frame].number});
        if (gaps->size() != 2)
            throw Error(fmt::format("option \"gaps\" has {} numbers; expected [short, long]", gaps->size()));
        std::array<Gap, 2> result{Gap{"short", (*gaps)[0], {}, 0, {}}, Gap{"long", (*gaps)[1], {}, 0, {}}};
        for (Gap& gap : result)
        {
            gap.pairs = frame_pairs(places, gap.length);
            gap.without_target = pictures.size() - gap.pairs.size();
        }
        if (result[0].pairs.empty() && result[1].pairs.empty())
            throw Error(
                fmt::format("none of the {} frames with a picture has another {} or {} recorded numbers later (the smallest "
                            "difference is {}): set gaps, or render more frames",
                            pictures.size(), result[0].length, result[1].length, smallest_gap(places)));
        for (Gap& gap : result)
            std::erase_if(gap.pairs, [&](const FramePair& pair) { return pair.source % static_cast<std::size_t>(*every) != 0; });
        return result;
    }

    void judge(std::array<Gap, 2>& all, ViewCache& cache, const Mesh& shown, const SurfacePaint& paint, RunContext& run) const
    {
        std::vector<std::pair<Gap*, FramePair>> jobs;
        for (Gap& gap : all)
            for (const FramePair& pair : gap.pairs)
                jobs.emplace_back(&gap, pair);
        // The views of neighboring sources are still in the cache.
        std::ranges::stable_sort(jobs, {}, [](const auto& job) { return job.second.source; });
        std::size_t done = 0;
        for (const auto& [gap, pair] : jobs)
        {
            run.check_canceled();
            const auto source = cache.get(pair.source);
            const auto target = cache.get(pair.target);
            gap->figures.push_back(judge_pair(pair, *source, *target, shown, paint, *min_covisible, run));
            run.progress(static_cast<double>(++done), static_cast<double>(jobs.size()), "pairs");
        }
    }

    Value pair_value(const PairFigures& pair, const std::vector<PosedPicture>& pictures) const
    {
        const auto name = [&](std::size_t i)
        { return frames->frames[pictures[i].frame].sequence + "_" + frames->frames[pictures[i].frame].name; };
        Value::Map entry{{"source", name(pair.pair.source)}, {"target", name(pair.pair.target)}, {"covisible", pair.covisible}};
        if (pair.dropped)
            entry.emplace_back("dropped", true);
        else
            for (const auto& [key, member] : named_figures)
                entry.emplace_back(key, evaluation::number_or_null(pair.*member));
        return entry;
    }

    /// Says a gap's figures in messages and in the report, and returns them for the file.
    Value tell(const Gap& gap, const std::vector<PosedPicture>& pictures, RunContext& run) const
    {
        const GapFigures all = summary(gap.figures, evaluation::usual_bootstrap);
        Value::Map entry{{"gap", static_cast<std::int64_t>(gap.length)},
                         {"pairs", all.kept},
                         {"dropped_pairs", all.dropped},
                         {"flat_pairs", all.flat},
                         {"frames_without_target", gap.without_target},
                         {"invalid", all.invalid}};
        for (std::size_t i = 0; i < all.figures.size(); ++i)
        {
            const auto& [value, interval] = all.figures[i];
            const std::string key = named_figures[i].first;
            entry.emplace_back(key, evaluation::figure(value, interval));
            run.message(gap.name + " " + key + " " + evaluation::figure_text(value, interval));
        }
        for (const auto& [key, value] : entry)
            run.report(gap.name + "_" + key, value);
        run.message(fmt::format("{}: {} pairs {} apart, {} dropped (too little in common), {} frames without a target", gap.name,
                                all.kept, gap.length, all.dropped, gap.without_target));
        if (all.kept == 0)
            run.warning("the " + gap.name + " range has no pair: its figures are undefined");
        else if (all.invalid)
            run.warning(fmt::format(
                "the {} figures are invalid: {} of {} pictures have no detail, and a flat picture is consistent with anything",
                gap.name, all.flat, all.kept));
        Value::List list;
        for (const PairFigures& pair : gap.figures)
            list.push_back(pair_value(pair, pictures));
        entry.emplace_back("pair_figures", std::move(list));
        return entry;
    }

    void run(RunContext& run) override
    {
        const Mesh& shown =
            evaluation::shown_mesh(textured_mesh.has_value() ? &*textured_mesh : nullptr, mesh.has_value() ? &*mesh : nullptr);
        check_offset(*frames, shown);
        const auto pictures = evaluation::posed_pictures(*frames, views.has_value() ? &*views : nullptr, folder->path, run);
        const SurfacePaint paint = floor_paint();
        std::array<Gap, 2> all = paired(pictures);
        const raycast::Scene scene(shown);
        ViewCache cache([&](std::size_t i) { return load_view(pictures[i], scene, run); });
        judge(all, cache, shown, paint, run);

        Value::Map result{{"unit", "mean absolute difference, 0 to 1"},
                          {"gap_unit", "recorded frame numbers"},
                          {"floor_of", paint ? "texture" : "picture"},
                          {"pictures", pictures.size()},
                          {"every", *every}};
        for (const auto& [key, value] : result)
            run.report(key, value);
        for (const Gap& gap : all)
            result.emplace_back(gap.name, tell(gap, pictures, run));
        figures = evaluation::write_figures(figures.folder(), path->path, result);
    }
};

}  // namespace

FRESCO_STAGE("evaluate.reprojection", EvaluateReprojection,
             "Measures how consistent pictures are across views, relative to the error of resampling")
FRESCO_LIBRARY("Embree", raycast::embree_version())
