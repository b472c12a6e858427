#pragma once

#include <fresco/geometry/flatten.h>

#include <cstdint>
#include <vector>

/// The charts of texcoords that a mesh brings along: faces are in one chart if a path of edges connects them across which the
/// texcoords of both ends are equal. Numbered without gaps by first face.
std::vector<std::uint32_t> uv_charts(const fresco::Mesh& mesh);

/// Measures of texcoords as they are.
struct UvMeasures
{
    double used_share = 0;      ///< Share of the square: the faces' areas, overlaps counted every time.
    double overlap_share = 0;   ///< Share of that area in faces that lie on another face deeper than the tolerance.
    double mirrored_share = 0;  ///< Share of that area in faces laid with their outside down.
};
/// `tolerance` in uv. Takes all charts together, so that charts on top of each other are found too.
UvMeasures measure_uv(const fresco::Mesh& mesh, double tolerance);
