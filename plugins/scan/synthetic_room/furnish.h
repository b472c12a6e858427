#pragma once

#include "scene.h"

/// \file Builds the furnished scene that the stage records.

namespace room
{

/// Furnishes a room of these inner edges (meters; at least 3.5 x 3 x 2.2): table and chairs on a rug, shelf with books, sofa,
/// sideboard, plant, lamps, paintings, door and a window. Longer rooms get more furniture. The same seed gives the same room.
Scene furnish(Vec3f size, std::uint32_t seed);

}  // namespace room
