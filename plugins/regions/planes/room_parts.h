#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

/// \file Divides a room into floor, ceiling, walls and furniture, for the stage.

enum class RoomPart : std::uint8_t
{
    floor,
    ceiling,
    walls,
    furniture  ///< All other faces.
};
inline constexpr std::array<std::string_view, 4> room_part_names{"floor", "ceiling", "walls", "furniture"};

/// A chair is larger; scattered pieces of a scan are smaller.
inline constexpr double least_furniture_m2 = 0.3;
inline constexpr std::size_t most_furniture = 32;

struct RoomParts
{
    std::vector<RoomPart> of_face;  ///< F
    /// F: the connected piece of furniture that the face is of, from 1 by falling area; 0 for small pieces and the other parts.
    std::vector<std::uint16_t> furniture_of_face;
    std::size_t furniture_count = 0;        ///< Pieces of least_furniture_m2 or more, at most most_furniture.
    std::vector<double> floor_heights_m;    ///< Heights of all levels, ascending; empty if none was found.
    std::vector<double> ceiling_heights_m;  ///< The lowest and the highest; empty if none was found.
    std::size_t wall_planes = 0;
};

/// Finds floor, ceiling and walls of a scanned room by its planes; README.md describes the method. z is up, meters.
/// The mesh must have passed check_mesh. The same for any number of threads. Throws Canceled.
RoomParts find_room_parts(const fresco::Mesh& upright, const fresco::Progress& progress);
