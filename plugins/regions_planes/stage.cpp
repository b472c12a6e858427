#include "room_parts.h"
#include <fresco/regions/regions.h>

#include <fresco/geometry/topology.h>
#include <fresco/geometry/upright.h>
#include <fresco/stage.h>

using namespace fresco;

namespace
{

std::vector<std::string> part_names()
{
    return {room_part_names.begin(), room_part_names.end()};
}

class RegionsPlanes final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The mesh to divide"};
    Input<Frames> frames{this, "frames", optional, "Frames whose cameras show which way is up"};
    Output<Regions> regions{this, "regions", Parts{part_names()}, "Floor, ceiling, walls, and furniture: all else"};
    Option<double> thickness_cm{this, "thickness_cm", 6, range(1, 30),
                                "What is as close to the floor, a wall or the ceiling belongs to it: rugs, pictures, doors"};
    Option<std::string> up = geometry::up_option(this);

    Cost cost() const override
    {
        return {.seconds = {.per = {{count::faces, 4e-6}}},
                .parallel_share = 0.4,
                .memory_mb = {.fixed = 30, .per = {{count::faces, 3e-4}}},
                .disk_mb = {.per = {{count::faces, 2e-6}}}};
    }

    /// Where the mesh does not clearly show it, the side that more of its level surface faces: tables and shelves, if not floors.
    Vec3d found_upward(RunContext& run) const
    {
        const geometry::Upward found = geometry::found_up(*mesh, frames, run);
        if (found.from != geometry::UpEvidence::nothing)
            return found.direction;
        run.warning("the mesh does not clearly show which way is up: wire 'frames', whose cameras show it, or set 'up'");
        constexpr double level_cosine = 0.97;
        double up_m2 = 0;
        double down_m2 = 0;
        for (std::size_t f = 0; f < mesh->triangles.size(); ++f)
        {
            const Vec3d vector = geometry::area_vector(*mesh, f);
            const double area = length(vector);
            const double along = dot(vector, found.direction);
            up_m2 += along > level_cosine * area ? area : 0;
            down_m2 += along < -level_cosine * area ? area : 0;
        }
        return down_m2 > up_m2 ? -found.direction : found.direction;
    }

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        const Vec3d upward = *up == "auto" ? found_upward(run) : geometry::named_up(*up, *mesh, run);
        run.report("up", Value::List{upward.x, upward.y, upward.z});
        const auto turn = geometry::upright_turn(upward, {0, 0, 1});
        Mesh upright;
        upright.triangles = mesh->triangles;
        upright.positions.reserve(mesh->positions.size());
        for (const Vec3f& position : mesh->positions)
            upright.positions.push_back(vec_cast<float>(geometry::turned(turn, vec_cast<double>(position))));
        const RoomParts parts = find_room_parts(upright, *thickness_cm / 100, run);

        Regions result;
        result.atlas = atlas_id(*mesh);
        result.names = part_names();
        for (const RoomPart part : parts.of_face)
            result.label_of_face.push_back(static_cast<std::uint16_t>(part));
        if (parts.floor_heights_m.empty())
            run.warning("no floor was found; if the mesh has one, set 'up' to the axis that points up");
        run.report("floors", parts.floor_heights_m.size());
        run.report("wall_planes", parts.wall_planes);
        if (!parts.floor_heights_m.empty() && !parts.ceiling_heights_m.empty())
            run.report("ceiling_m", parts.ceiling_heights_m.back() - parts.floor_heights_m.front());
        report_regions(result, *mesh, run);
        regions = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("regions.planes", RegionsPlanes, "Divides a room into floor, ceiling, walls and furniture by its planes")
