#pragma once

#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

enum class RoomPart : std::uint8_t
{
    floor,
    ceiling,
    walls,
    furniture  ///< All else.
};
inline constexpr std::array<std::string_view, 4> room_part_names{"floor", "ceiling", "walls", "furniture"};

struct RoomParts
{
    std::vector<RoomPart> of_face;          ///< F
    std::vector<double> floor_heights_m;    ///< Of each level, ascending; empty: none was found.
    std::vector<double> ceiling_heights_m;  ///< The lowest and the highest; empty: none was found.
    std::size_t wall_planes = 0;
};

/// Finds floor, ceiling and walls of a scanned room by its planes; README.md says how. z is up, meters. `thickness_m`: what lies
/// as close to a plane and faces roughly its way belongs to it. The mesh must have passed check_mesh. The same for any number of
/// threads. Throws Canceled.
RoomParts find_room_parts(const fresco::Mesh& upright, double thickness_m, const fresco::Progress& progress);
