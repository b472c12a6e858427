#include "room_parts.h"
#include <fresco/regions/regions.h>

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
    Option<std::string> up = geometry::up_option(this);

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        const Vec3d upward = geometry::shown_up(*up, *mesh, frames, run);
        run.report("up", Value::List{upward.x, upward.y, upward.z});
        const auto turn = geometry::upright_turn(upward, {0, 0, 1});
        Mesh upright;
        upright.triangles = mesh->triangles;
        upright.positions.reserve(mesh->positions.size());
        for (const Vec3f& position : mesh->positions)
            upright.positions.push_back(vec_cast<float>(geometry::turned(turn, vec_cast<double>(position))));
        const RoomParts parts = find_room_parts(upright, run);

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
