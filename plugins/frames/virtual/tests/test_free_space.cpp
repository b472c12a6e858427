#include "catch.h"
#include "free_space.h"
#include "rooms.h"

#include <fresco/numerics/numerics.h>
#include <fresco/testing.h>

#include <set>

using namespace fresco;
using namespace fresco::virtual_views;
using namespace rooms;

namespace
{

/// Voxel by voxel, until a whole pass over all of them reaches none more; every ray against every triangle.
std::vector<Vec3d> slow_free_space(const Mesh& mesh, const VoxelGrid& grid, const std::vector<Vec3d>& eyes, double clearance_m)
{
    const auto open = [&](Vec3d from, Vec3d to)
    {
        const auto hit = testing::cast(mesh, from, to - from);
        return !hit.found() || hit.distance > 1;
    };
    std::set<std::size_t> reached;
    for (const Vec3d eye : eyes)
        for (const std::size_t voxel : grid.around(eye))
            if (open(eye, grid.center(voxel)))
                reached.insert(voxel);
    for (std::size_t before = 0; before != reached.size();)
    {
        before = reached.size();
        for (std::size_t voxel = 0; voxel < grid.count(); ++voxel)
            for (const std::size_t from : grid.beside(voxel))
                if (reached.contains(from) && open(grid.center(from), grid.center(voxel)))
                    reached.insert(voxel);
    }
    std::vector<Vec3d> result;
    for (const std::size_t voxel : reached)
    {
        int backs = 0;
        int met = 0;
        bool near = false;
        for (const Vec3d direction : numerics::spread_directions(64))
        {
            const auto hit = testing::cast(mesh, grid.center(voxel), direction);
            met += hit.found() ? 1 : 0;
            backs += hit.found() && !hit.front ? 1 : 0;
            near = near || (hit.found() && hit.distance < clearance_m);
        }
        if (!near && met > 0 && 4 * backs <= met)
            result.push_back(grid.center(voxel));
    }
    return result;
}

}  // namespace

TEST_CASE("free space is what ways lead to, as every triangle tried in turn says", "[frames.virtual]")
{
    const Mesh mesh = room_with_cupboard();
    const raycast::Scene scene(mesh);
    const std::vector<Vec3d> eyes{{1, 1.5, 1.4}};
    for (const double clearance_m : {0.1, 0.3})
    {
        const VoxelGrid grid(mesh, eyes, {.voxel_m = 0.31, .clearance_m = clearance_m});
        const auto places = free_space(scene, grid, eyes, clearance_m, testing::TestRun(2));
        CHECK(places == slow_free_space(mesh, grid, eyes, clearance_m));
        bool behind_cupboard = false;
        for (const Vec3d place : places)
        {
            // Not in the walled-off space, not inside the cupboard, nowhere near a wall.
            CHECK(place.x < 4 - 0.9 * clearance_m);
            CHECK_FALSE((place.x > 2.7 && place.x < 3.2 && place.y > 0.9 && place.y < 2.1 && place.z < 1.8));
            behind_cupboard = behind_cupboard || (place.x > 3.2 && place.y > 1 && place.y < 2 && place.z < 1.7);
        }
        // The gap there is 0.8 m wide, and voxels of 0.31 m leave no center in the middle 0.2 m of it.
        CHECK(behind_cupboard == (clearance_m < 0.3));
    }
    // The eye alone decides which side of the wall counts: the space behind it shows only backs of faces, and one front.
    const std::vector<Vec3d> outside{{4.5, 1.5, 1.2}};
    const VoxelGrid grid(mesh, outside, {.voxel_m = 0.31, .clearance_m = 0.1});
    CHECK(free_space(scene, grid, outside, 0.1, testing::TestRun(1)) == slow_free_space(mesh, grid, outside, 0.1));
}

TEST_CASE("a hole in a wall opens no space behind it", "[frames.virtual]")
{
    // The floor is missing: ways lead below it, where the other walls show their backs.
    Mesh mesh = room_with_cupboard();
    mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);
    mesh.texcoords.erase(mesh.texcoords.begin(), mesh.texcoords.begin() + 6);
    const raycast::Scene scene(mesh);
    const std::vector<Vec3d> eyes{{1, 1.5, 1.4}};
    const VoxelGrid grid(mesh, eyes, {.voxel_m = 0.31, .clearance_m = 0.1});
    const auto places = free_space(scene, grid, eyes, 0.1, testing::TestRun(2));
    CHECK(places == slow_free_space(mesh, grid, eyes, 0.1));
    CHECK(places.size() > 100);
    for (const Vec3d place : places)
        CHECK(place.x < 4);
}
