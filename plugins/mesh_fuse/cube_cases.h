#pragma once

#include <array>
#include <cstdint>

namespace fuse
{

/// An edge of a cube, from a corner along an axis. Bit k of a corner's number says whether it is at the far end of axis k.
struct CubeEdge
{
    int corner = 0;
    int axis = 0;
};

/// The triangles of marching cubes in a cube, each three edges on which the corners lie, counter-clockwise seen from outside.
struct CubeCase
{
    int count = 0;
    std::array<std::array<std::uint8_t, 3>, 5> triangles{};
};

const std::array<CubeEdge, 12>& cube_edges();

/// By the corners inside the surface: bit i for corner i. Where the corners of a face are inside and outside in turns, the
/// surface cuts off those inside, in both cubes of the face: there are no cracks (Lorensen and Cline, "Marching cubes", 1987,
/// left this open). No edge between two triangles of a cube lies in one of its faces, so that no edge has more than two
/// triangles.
const std::array<CubeCase, 256>& cube_cases();

}  // namespace fuse
