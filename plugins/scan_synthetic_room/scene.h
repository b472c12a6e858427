#pragma once

#include "solids.h"

#include <cstdint>
#include <vector>

namespace room
{

enum class Pattern : std::uint8_t
{
    plaster,
    planks,
    brick,
    wallpaper,
    wood,
    fabric,
    rug,
    painting,
    book,
    leaf,
    ceramic,
    panels,
    basket,
    sky,
    shade
};

/// What a face looks like. Colors are display sRGB, 0..1.
struct Material
{
    Pattern pattern = Pattern::plaster;
    Vec3f first;
    Vec3f second;
    float scale = 1;  ///< Meters per feature, where the pattern has one.
    std::uint32_t seed = 0;
    float emission = 0;  ///< Radiant exitance of lamps and windows; 0: lit by others only.
};

struct Scene
{
    Vec3f size;                 ///< Inner edges of the room; the floor is z = 0, the corner (0, 0, 0).
    std::vector<Solid> solids;  ///< solids[0] is the hollow room.
    std::vector<Material> materials;

    const Material& material(int solid, int face) const
    {
        const auto& body = solids[static_cast<std::size_t>(solid)];
        return materials[body.materials[static_cast<std::size_t>(face)]];
    }
};

/// Free space around a point: positive in the air, negative inside furniture or beyond the walls.
float free_distance(const Scene& scene, Vec3f point);

}  // namespace room
