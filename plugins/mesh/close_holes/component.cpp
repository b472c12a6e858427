#include "holes.h"

#include <fresco/hole_closer.h>
#include <fresco/option.h>
#include <fresco/stage.h>

#include <fmt/format.h>
#include <vector>

using namespace fresco;

namespace
{

class CloseHoles final : public HoleCloser
{
    Option<double> max_width_cm{this, "max_width_cm", 30.0, range(0, 1000),
                                "Close holes of at most this width; wider ones are where the scan ends"};

  public:
    Mesh closed(const Mesh& mesh, const std::vector<const Frame*>& measured, const std::function<RasterF(const Frame&)>& depth,
                RunContext& run) const override
    {
        HoleFigures figures;
        std::vector<HolePatch> patches = hole_patches(mesh, *max_width_cm / 100, run, figures);
        constexpr std::size_t most_views = 200;
        const std::size_t step = 1 + measured.size() / most_views;
        for (std::size_t i = 0; i < measured.size(); i += step)
        {
            run.check_canceled();
            judge(patches, measured[i]->depth, depth(*measured[i]));
            run.progress(static_cast<double>(i), static_cast<double>(measured.size()), "frames");
        }
        Mesh result = with_patches(mesh, patches, figures);
        run.message(fmt::format(
            "{} holes closed with {} faces ({:.2f} m²); open: {} that cameras looked through, {} wider than {:g} cm, {} "
            "around small pieces{}",
            figures.closed, figures.faces_added, figures.area_m2, figures.openings, figures.too_large, *max_width_cm,
            figures.outer, figures.failed > 0 ? fmt::format(", {} that no surface fills", figures.failed) : ""));
        run.report("holes_closed", figures.closed);
        run.report("openings", figures.openings);
        run.report("holes_too_large", figures.too_large);
        run.report("holes_outer", figures.outer);
        run.report("holes_failed", figures.failed);
        run.report("faces_before", mesh.triangles.size());
        run.report("faces_after", result.triangles.size());
        run.report("added_area_m2", figures.area_m2);
        return result;
    }
};

}  // namespace

FRESCO_COMPONENT("mesh.close_holes", CloseHoles, HoleCloser, "Closes small holes of a scanned surface with smooth patches")
