#include "holes.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <fmt/format.h>
#include <vector>

using namespace fresco;

namespace
{

class MeshCloseHoles final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "Triangle mesh; texture coordinates are dropped"};
    Input<Frames> frames{this, "frames", optional, "Recording whose depth shows which holes are real openings, which stay open"};
    Output<Mesh> closed{this, "closed", "The same faces, and those that fill holes"};
    Option<double> max_width_cm{this, "max_width_cm", 30.0, range(0, 1000),
                                "Close holes of at most this width; wider ones are where the scan ends"};
    Slot<ImageIo> images{this, optional, "Reads depth pictures that are not NPY"};

    void judge_by_frames(std::vector<HolePatch>& patches, RunContext& run) const
    {
        constexpr std::size_t most_views = 200;
        std::vector<const Frame*> measured;
        for (const Frame& frame : frames->frames)
            if (!frame.depth_picture.empty())
                measured.push_back(&frame);
        const std::size_t step = 1 + measured.size() / most_views;
        for (std::size_t i = 0; i < measured.size(); i += step)
        {
            run.check_canceled();
            judge(patches, measured[i]->depth, load_depth(*measured[i], images.has_value() ? images.get().get() : nullptr));
            run.progress(static_cast<double>(i), static_cast<double>(measured.size()), "frames");
        }
    }

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        HoleFigures figures;
        std::vector<HolePatch> patches = hole_patches(*mesh, *max_width_cm / 100, run, figures);
        if (frames.has_value())
            judge_by_frames(patches, run);
        Mesh result = with_patches(*mesh, patches, figures);
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
        run.report("faces_before", mesh->triangles.size());
        run.report("faces_after", result.triangles.size());
        run.report("added_area_m2", figures.area_m2);
        closed = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("mesh.close_holes", MeshCloseHoles, "Closes small holes of a scanned surface with smooth patches")
