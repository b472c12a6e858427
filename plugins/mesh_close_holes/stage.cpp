#include "holes.h"

#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <fmt/format.h>

using namespace fresco;

namespace
{

class MeshCloseHoles final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "Triangle mesh; texture coordinates are dropped"};
    Output<Mesh> closed{this, "closed", "The same faces, and those that fill holes"};
    Option<double> max_width_cm{this, "max_width_cm", 30.0, range(0, 1000),
                                "Close holes of at most this width; wider ones are where the scan ends"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 0.2, .per = {{count::faces, 2e-6}}},
                .memory_mb = {.fixed = 20, .per = {{count::faces, 1.6e-4}}},
                .disk_mb = {.per = {{count::faces, 2.1e-5}}}};
    }

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        HoleFigures figures;
        Mesh result = with_holes_closed(*mesh, *max_width_cm / 100, run, figures);
        run.message(
            fmt::format("{} holes closed with {} faces ({:.2f} m²); open: {} wider than {:g} cm, {} around small pieces{}",
                        figures.closed, figures.faces_added, figures.area_m2, figures.too_large, *max_width_cm, figures.outer,
                        figures.failed > 0 ? fmt::format(", {} that no surface fills", figures.failed) : ""));
        run.report("holes_closed", figures.closed);
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
