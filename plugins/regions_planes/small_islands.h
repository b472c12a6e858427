#pragma once

#include "room_parts.h"

#include <fresco/geometry/charts.h>

#include <vector>

/// Gives connected pieces of one part that are smaller than a hand the part that most of their border meets: switches, handles,
/// scraps of noise.
void absorb_small_islands(const fresco::geometry::Surface& surface, std::vector<RoomPart>& of_face);
