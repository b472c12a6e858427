#include "seen_cells.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/images/sharpness.h>
#include <fresco/mesh.h>
#include <fresco/numerics/greedy_cover.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>
#include <fresco/stage.h>
#include <fresco/uv_mapping/uv_mapping_stage.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

using namespace fresco;

namespace
{

std::string percent(double share)
{
    const auto tenths = std::lround(share * 1000);
    return fmt::format("{}.{} %", tenths / 10, tenths % 10);
}

class FramesCover final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The room, with texcoords, as an atlas.* stage makes it"};
    Input<Frames> frames{this, "frames", "The frames to choose from; their color cameras and masks are used"};
    Output<Frames> chosen{this, "frames", "The chosen frames, in the same order"};
    Option<double> target_coverage{this, "target_coverage", 0.99, range(0.01, 1),
                                   "Stop when this share of all visible cells is covered"};
    Option<int> max_frames{this, "max_frames", 0, range(0, 10'000'000),
                           "Maximum number of frames; 0: as many as the target needs"};
    Option<double> max_share{this, "max_share", 1, range(1e-6, 1), "Maximum share of the frames"};
    Option<double> min_seen_share{this, "min_seen_share", 0.05, range(0, 1),
                                  "Do not choose frames on whose picture the mesh covers less than this share"};
    Option<int> cells_px{this, "cells_px", 1024, range(16, 4096), "Cells along a side of the grid over the texture"};
    Option<int> height_px{this, "height_px", 256, range(16, 4096), "Height at which frames view the mesh; the width follows"};
    Option<double> angle_weight{this, "angle_weight", 0.3, range(0, 100),
                                "Value of seeing a cell straight on, added to 1 for seeing it at all"};
    Option<double> sharpness_weight{this, "sharpness_weight", 0.1, range(0, 100),
                                    "Value of a picture at least as sharp as the median; 0: do not read pictures"};
    SharpnessOption sharpness{this};
    Slot<ImageIo> images{this, optional, "Reads pictures that are not NPY; none: all are NPY"};

    using SeenByFrame = std::vector<std::vector<numerics::SeenCell>>;

    void run(RunContext& run) override
    {
        check_uv_mapping_inputs(*mesh, *frames);
        sharpness.check();
        const auto seen = look(relative_sharpness(run), run);
        const auto side = static_cast<std::size_t>(*cells_px);
        const auto order = numerics::greedy_order(seen, side * side, run);
        if (order.empty())
            throw Error(fmt::format(
                "none of the {} frames sees the front of the mesh on min_seen_share of its picture: check with scan.inspect that "
                "mesh and poses share one world frame and that faces are counter-clockwise from outside",
                seen.size()));
        const std::size_t picks = numerics::picks_needed(order, *target_coverage, most_frames());
        std::vector<std::size_t> kept(picks);
        for (std::size_t i = 0; i < picks; ++i)
            kept[i] = order[i].frame;
        std::ranges::sort(kept);
        Frames result;
        for (const std::size_t i : kept)
            result.frames.push_back(frames->frames[i]);
        report(seen, order, picks, run);
        chosen = std::move(result);
    }

    std::size_t most_frames() const
    {
        const std::size_t all = frames->frames.size();
        const auto share = static_cast<std::size_t>(*max_share * static_cast<double>(all) * (1 + 1e-12));
        const std::size_t limit = *max_frames == 0 ? all : static_cast<std::size_t>(*max_frames);
        return std::max<std::size_t>(1, std::min(limit, share));
    }

    /// Per frame, in [0,1]: 1 for pictures that are at least as sharp as the median one.
    std::vector<double> relative_sharpness(Progress& progress) const
    {
        const auto& all = frames->frames;
        std::vector<double> sharp(all.size(), 1);
        if (*sharpness_weight == 0)
            return sharp;
        const ImageIo* codec = images.has_value() ? images.get().get() : nullptr;
        parallel_for_each(all.size(), "pictures", progress,
                          [&](std::size_t i) { sharp[i] = sharpness.of(load_color(all[i], codec)); });
        const double median = numerics::median(sharp);
        for (double& value : sharp)
            value = median > 0 ? std::min(1.0, value / median) : 1;
        return sharp;
    }

    SeenByFrame look(const std::vector<double>& sharp, Progress& progress) const
    {
        UvMapper mapper(*mesh, std::make_unique<raycast::RayFinder>(*mesh));
        const cover::WorthRules rules{.angle_weight = *angle_weight, .sharpness_weight = *sharpness_weight};
        const std::array heights{*height_px};
        SeenByFrame seen;
        for (const Frame& frame : frames->frames)
        {
            progress.check_canceled();
            const auto& maps = mapper.make(frame.color, heights, progress, load_mask(frame));
            const auto& [map, counts] = maps.front();
            const bool sees = static_cast<double>(counts.valid) >= *min_seen_share * static_cast<double>(map.valid.values.size());
            seen.push_back(sees ? cover::seen_cells(map, *cells_px, sharp[seen.size()], rules)
                                : std::vector<numerics::SeenCell>{});
            progress.progress(static_cast<double>(seen.size()), static_cast<double>(sharp.size()), "frames");
        }
        return seen;
    }

    void report(const SeenByFrame& seen, const std::vector<numerics::Pick>& order, std::size_t picks, RunContext& run) const
    {
        const auto side = static_cast<std::size_t>(*cells_px);
        std::vector<std::int64_t> covered{0};  // By so many picks.
        for (const numerics::Pick& pick : order)
            covered.push_back(covered.back() + pick.new_cells);
        const auto share = [&](std::int64_t cells) { return static_cast<double>(cells) / static_cast<double>(covered.back()); };
        const auto first = [&](std::size_t count) { return share(covered[std::min(count, order.size())]); };
        const auto spread = [&](std::size_t count)
        { return share(numerics::cells_seen(seen, numerics::evenly_spread(count, seen.size()), side * side)); };

        run.report("frames", seen.size());
        run.report("kept", picks);
        run.report("cells", covered.back());
        run.report("coverage", first(picks));
        run.report("coverage_evenly_spread", spread(picks));
        run.report("blind_frames", std::ranges::count_if(seen, [](const auto& cells) { return cells.empty(); }));
        Value::List rows;
        for (const double part : {0.1, 0.2, 1 / 3.0, 0.5, 2 / 3.0})
        {
            const auto count = static_cast<std::size_t>(part * static_cast<double>(seen.size()) + 1e-9);
            if (count > 0)
                rows.emplace_back(Value::Map{{"frames", count}, {"coverage", first(count)}, {"evenly_spread", spread(count)}});
        }
        run.report("coverage_by_frames", std::move(rows));
        run.message(fmt::format("{} of {} frames see {} of what all see; as many evenly spread ones {}", picks, seen.size(),
                                percent(first(picks)), percent(spread(picks))));
    }
};

}  // namespace

FRESCO_STAGE("frames.cover", FramesCover, "Chooses the fewest frames that see all of the mesh sharply and from good angles")
FRESCO_LIBRARY("Embree", raycast::embree_version())
