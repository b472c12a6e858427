#include "decimate.h"
#include "repair.h"

#include <fresco/geometry/topology.h>
#include <fresco/stage.h>

#include <OpenMesh/Core/System/config.h>

#include <string>

namespace
{

void report_counts(fresco::RunContext& run, const std::string& when, const fresco::geometry::SurfaceCounts& counts)
{
    run.report("faces_" + when, counts.faces);
    run.report("vertices_" + when, counts.vertices);
    run.report("components_" + when, counts.components);
    run.report("border_length_m_" + when, counts.border_length_m);
    run.report("area_m2_" + when, counts.area_m2);
}

void report_repair(fresco::RunContext& run, const RepairReport& repair)
{
    run.report("duplicate_faces_removed", repair.duplicate_faces);
    run.report("degenerate_faces_removed", repair.degenerate_faces);
    run.report("vertices_welded", repair.vertices_welded);
    run.report("complex_edges_repaired", repair.complex_edges);
    run.report("vertices_added", repair.vertices_added);
    run.report("faces_detached", repair.faces_detached);
    run.report("unused_vertices_removed", repair.vertices_unused);
}

class MeshDecimate final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh to simplify"};
    fresco::Output<fresco::Mesh> simplified{this, "simplified", "The same surface with fewer triangles"};
    fresco::Option<int> max_faces{this, "max_faces", 500'000, fresco::range(4, 50'000'000), "Stop at this many triangles"};

    fresco::Cost cost() const override
    {
        return {.seconds = "1 + 0.000002 * faces + 0.00002 * max(faces - max_faces, 0)",
                .memory_mb = "60 + 0.0002 * faces",
                .disk_mb = "0.000022 * min(faces, max_faces)",
                .frames = "",
                .faces = "min(faces, max_faces)"};
    }

    void run(fresco::RunContext& run) override
    {
        fresco::check_mesh(*mesh, "mesh.decimate: input mesh");
        if (!mesh->texcoords.empty())
            run.message("the mesh's own texture coordinates are dropped: a simplified surface needs a new atlas");
        report_counts(run, "before", fresco::geometry::count_surface(*mesh));

        RepairReport repair;
        auto result = repaired(*mesh, repair, run);
        report_repair(run, repair);
        if (result.triangles.empty())
            throw fresco::Error("mesh.decimate: no face of the mesh has any area: check how it was made");
        const auto clean = fresco::geometry::count_surface(result);
        if (2 * clean.border_edges > clean.edges)
            run.warning(
                "more than half of the edges belong to one face only: if faces do not share vertices, merge equal vertices "
                "first, or nothing can be simplified");

        const auto target = static_cast<std::size_t>(*max_faces);
        if (result.triangles.size() > target)
            result = decimated(result, {.max_faces = target}, run);
        const auto after = fresco::geometry::count_surface(result);
        report_counts(run, "after", after);
        if (after.components < clean.components)
            run.warning(std::to_string(clean.components - after.components) + " of " + std::to_string(clean.components) +
                        " components were lost");
        if (after.faces > target)
            run.warning("stopped at " + std::to_string(after.faces) + " faces instead of " + std::to_string(target) + ": the " +
                        std::to_string(clean.components) +
                        " components cannot be simplified further without losing or folding some");
        simplified = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("mesh.decimate", MeshDecimate, "Quadric edge collapse until at most max_faces triangles are left")
/// "9.0" of 0x90000.
constexpr char open_mesh_version[] = {'0' + OM_GET_VER, '.', '0' + OM_GET_MAJ, '\0'};
FRESCO_LIBRARY("OpenMesh", open_mesh_version)
