#include "covering.h"

#include <fresco/images/sharpness.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace fresco::cover
{

using numerics::SeenCell;

std::vector<SeenCell> seen_cells(const UvMap& map, int cells_px, double sharpness, const WorthRules& rules)
{
    const double most = 1 + rules.angle_weight + rules.sharpness_weight;
    const double base = 1 + rules.sharpness_weight * sharpness;
    const auto along = [&](float share)
    { return std::clamp(static_cast<int>(share * static_cast<float>(cells_px)), 0, cells_px - 1); };
    std::vector<SeenCell> seen;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
    {
        if (map.valid.values[i] == 0)
            continue;
        const auto cell = static_cast<std::uint32_t>(along(map.uv.values[2 * i + 1]) * cells_px + along(map.uv.values[2 * i]));
        const double worth = (base + rules.angle_weight * static_cast<double>(map.cosine.values[i])) / most;
        seen.emplace_back(cell, static_cast<std::uint32_t>(std::lround(1 + worth * (SeenCell::best_worth - 1))));
    }
    // By cell, the best first.
    std::ranges::sort(seen, {}, [](SeenCell cell) { return std::pair(cell.cell(), -static_cast<int>(cell.worth())); });
    const auto rest = std::ranges::unique(seen, {}, &SeenCell::cell);
    seen.erase(rest.begin(), rest.end());
    seen.shrink_to_fit();
    return seen;
}

namespace
{

std::string percent(double share)
{
    const auto tenths = std::lround(share * 1000);
    return fmt::format("{}.{} %", tenths / 10, tenths % 10);
}

using SeenByFrame = std::vector<std::vector<SeenCell>>;

class Covering
{
  public:
    Covering(const Mesh& mesh, const Frames& frames, const CoverOptions& options, const ImageIo* images)
        : mesh_(mesh), frames_(frames), options_(options), images_(images)
    {
    }

    Frames chosen(RunContext& run) const
    {
        const auto seen = look(relative_sharpness(run), run);
        const auto order = numerics::greedy_order(seen, cell_count(), run);
        if (order.empty())
            throw Error(fmt::format(
                "none of the {} frames sees the front of the mesh on {} % of its picture: check with scan.inspect that "
                "mesh and poses share one world frame and that faces are counter-clockwise from outside",
                seen.size(), 100 * options_.min_seen_share));
        const std::size_t picks = numerics::picks_needed(order, options_.target_coverage, most_frames());
        std::vector<std::size_t> kept(picks);
        for (std::size_t i = 0; i < picks; ++i)
            kept[i] = order[i].frame;
        std::ranges::sort(kept);
        Frames result;
        result.offset_m = frames_.offset_m;
        for (const std::size_t i : kept)
            result.frames.push_back(frames_.frames[i]);
        report(seen, order, picks, run);
        return result;
    }

  private:
    std::size_t cell_count() const
    {
        const auto side = static_cast<std::size_t>(options_.cells_px);
        return side * side;
    }

    std::size_t most_frames() const
    {
        const std::size_t all = frames_.frames.size();
        const auto share = static_cast<std::size_t>(options_.max_share * static_cast<double>(all) * (1 + 1e-12));
        const std::size_t limit = options_.max_frames == 0 ? all : static_cast<std::size_t>(options_.max_frames);
        return std::max<std::size_t>(1, std::min(limit, share));
    }

    /// Per frame, in [0,1]: 1 for pictures that are at least as sharp as the median one.
    std::vector<double> relative_sharpness(Progress& progress) const
    {
        const auto& all = frames_.frames;
        std::vector<double> sharp(all.size(), 1);
        if (options_.worth.sharpness_weight == 0)
            return sharp;
        parallel_for_each(all.size(), "pictures", progress,
                          [&](std::size_t i) { sharp[i] = usual_sharpness(load_color(all[i], images_)); });
        const double median = numerics::median(sharp);
        for (double& value : sharp)
            value = median > 0 ? std::min(1.0, value / median) : 1;
        return sharp;
    }

    SeenByFrame look(const std::vector<double>& sharp, Progress& progress) const
    {
        UvMapper mapper(mesh_, std::make_unique<rendering::RasterFinder>(mesh_));
        const std::array heights{options_.height_px};
        SeenByFrame seen;
        for (const Frame& frame : frames_.frames)
        {
            progress.check_canceled();
            const auto& maps = mapper.make(frame.color, heights, progress, load_mask(frame));
            const auto& [map, counts] = maps.front();
            const bool sees =
                static_cast<double>(counts.valid) >= options_.min_seen_share * static_cast<double>(map.valid.values.size());
            seen.push_back(sees ? seen_cells(map, options_.cells_px, sharp[seen.size()], options_.worth)
                                : std::vector<numerics::SeenCell>{});
            progress.progress(static_cast<double>(seen.size()), static_cast<double>(sharp.size()), "frames");
        }
        return seen;
    }

    void report(const SeenByFrame& seen, const std::vector<numerics::Pick>& order, std::size_t picks, RunContext& run) const
    {
        std::vector<std::int64_t> covered{0};  // By so many picks.
        for (const numerics::Pick& pick : order)
            covered.push_back(covered.back() + pick.new_cells);
        const auto share = [&](std::int64_t cells) { return static_cast<double>(cells) / static_cast<double>(covered.back()); };
        const auto first = [&](std::size_t count) { return share(covered[std::min(count, order.size())]); };
        const auto spread = [&](std::size_t count)
        { return share(numerics::cells_seen(seen, numerics::evenly_spread(count, seen.size()), cell_count())); };

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

    const Mesh& mesh_;
    const Frames& frames_;
    const CoverOptions& options_;
    const ImageIo* images_;
};

}  // namespace

Frames covering_frames(const Mesh& mesh, const Frames& frames, const CoverOptions& options, const ImageIo* images,
                       RunContext& run)
{
    check_uv_mapping_inputs(mesh, frames);
    return Covering(mesh, frames, options, images).chosen(run);
}

}  // namespace fresco::cover
