#include "mesh_axes.h"

#include <fresco/matrix_text.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>

#include <algorithm>
#include <cmath>

namespace
{

// A room's longest side; what lies beyond is likely in another unit.
constexpr double smallest_room_m = 0.3;
constexpr double largest_room_m = 300;

class ScanMesh final : public fresco::Stage
{
    fresco::Option<fresco::InputFile> path{this, "path", fresco::required, "Mesh, PLY or OBJ"};
    fresco::Option<double> unit_m{this, "unit_m", 1.0, fresco::range(1e-6, 1e6), "Metres per unit of the file"};
    fresco::Option<std::string> axes{this, "axes", "x y z",
                                     "Axes of the file that become x, y and z of the world; \"x -z y\" sets y-up meshes upright"};
    fresco::Option<std::vector<double>> transform{
        this, "transform", std::vector<double>{},
        "16 numbers, row by row: the world from the file, rigid, in metres, after unit_m and axes; empty: none"};

    fresco::Output<fresco::Mesh> mesh{this, "mesh", "The surface in the world"};

    void run(fresco::RunContext& run) override
    {
        const auto rotation = scan_mesh::axes_rotation(*axes);
        const auto world_from_file =
            transform->empty() ? fresco::RigidTransform{} : fresco::rigid_transform(*transform, "option transform");
        fresco::MeshReadReport read;
        auto surface = fresco::read_mesh(path->path, {}, &read);
        scan_mesh::move_mesh(surface, *unit_m, rotation, world_from_file);

        const auto extent = scan_mesh::extent_of(surface);
        warn_of_unit(std::max({extent.x, extent.y, extent.z}), run);
        run.report("faces", surface.triangles.size());
        run.report("extent_m", fresco::Value::List{extent.x, extent.y, extent.z});
        run.report("polygons_split", read.polygons_split);
        run.report("degenerate_dropped", read.degenerate_dropped);
        run.message(std::to_string(surface.triangles.size()) + " faces, " + metres(extent.x) + " x " + metres(extent.y) + " x " +
                    metres(extent.z) + " m");
        mesh = std::move(surface);
    }

    static std::string metres(double length) { return fresco::to_json(std::round(length * 100) / 100); }

    static void warn_of_unit(double longest, fresco::RunContext& run)
    {
        if (longest > largest_room_m)
            run.warning("the mesh is " + metres(longest) + " m long; if the file is in millimetres, give unit_m: 0.001");
        else if (longest < smallest_room_m)
            run.warning("the mesh is only " + fresco::to_json(std::round(longest * 1e4) / 1e4) +
                        " m long; give unit_m, the metres per unit of the file");
    }

    fresco::Cost cost() const override
    {
        return {.seconds = "1", .memory_mb = "50 + faces * 100 / 1e6", .disk_mb = "faces * 21 / 1e6", .faces = "1e6"};
    }
};

}  // namespace

FRESCO_STAGE("scan.mesh", ScanMesh, "A mesh from a file, brought into the world and the unit of the frames")
