#pragma once

#include <fresco/artifact.h>

/// \file How large a mesh's surface is, for estimates of stages whose work grows with it and not with the number of faces.

namespace fresco::count
{
inline constexpr Counted square_meters{.name = "square_meters", .assumed = 30, .carried_by = "mesh"};

/// Bytes of a scanned mesh (binary PLY) for a square meter, which has 28 000 faces where voxels of 1 cm were fused.
inline constexpr double scan_bytes_per_square_meter = 6e5;
}  // namespace fresco::count
