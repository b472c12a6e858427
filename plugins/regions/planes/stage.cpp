#include "room_parts.h"
#include "room_picture.h"

#include <fresco/image.h>
#include <fresco/regions/regions.h>

#include <fresco/geometry/upright.h>
#include <fresco/stage.h>

#include <fmt/format.h>

using namespace fresco;

namespace
{

/// The parts of a room, then this many numbered pieces of its furniture.
std::vector<std::string> part_names(std::size_t furniture_count)
{
    std::vector<std::string> names{room_part_names.begin(), room_part_names.end()};
    for (std::size_t number = 1; number <= furniture_count; ++number)
        names.push_back(fmt::format("furniture/part_{}", number));
    return names;
}

class RegionsPlanes final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The mesh to divide"};
    Input<Frames> frames{this, "frames", optional, "Frames whose cameras show which way is up"};
    Output<Regions> regions{this, "regions", Parts{part_names(most_furniture)},
                            "Floor, ceiling, walls, and furniture: all else, its large pieces numbered"};
    Output<Image> picture{this, "picture", "The room from two sides, with the numbers of the pieces"};
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
        result.names = part_names(parts.furniture_count);
        for (std::size_t f = 0; f < parts.of_face.size(); ++f)
            result.label_of_face.push_back(
                static_cast<std::uint16_t>(static_cast<std::size_t>(parts.of_face[f]) + parts.furniture_of_face[f]));
        picture = Image(room_picture(upright, parts, run));
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
