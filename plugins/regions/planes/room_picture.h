#pragma once

#include "room_parts.h"

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

/// \file A picture by which users tell the numbered furniture apart, for the report.

/// The room from two opposite sides above, through its ceiling and near walls: floor, walls and small furniture in grays, each
/// numbered piece in a color of its own with its number on it. z is up. RGB, 720 x 720. The same for any number of threads.
/// Throws Canceled.
fresco::Raster8 room_picture(const fresco::Mesh& upright, const RoomParts& parts, const fresco::Progress& progress);
