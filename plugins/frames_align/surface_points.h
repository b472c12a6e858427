#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::align
{

/// A place on the surface that views are compared at.
struct SurfacePoint
{
    Vec3f position;  ///< World, meters.
    Vec3f normal;
};

/// Vertices of the mesh, spread evenly: the first of each cell of a cubic grid, whose cells are the smallest of 5 mm, 7 mm, 1 cm,
/// … (steps of √2) with at most `most` points.
std::vector<SurfacePoint> surface_points(const Mesh& mesh, std::size_t most);

/// A point that a view sees.
struct Sighting
{
    std::uint32_t point = 0;
    float weight = 0;  ///< Cosine of the angle between normal and view.
    Vec3f in_camera;   ///< The point in the color camera as recorded, meters.
};

/// The points that a camera sees, none beside a depth step: where nothing within two pixels of the depth picture is nearer than
/// the point by more than 3 % + 2 cm, nor farther. `depth`: the mesh's, of the camera's size, meters, 0 = nothing. Ascending.
std::vector<Sighting> sightings(const std::vector<SurfacePoint>& points, const Camera& camera, const RasterF& depth);

}  // namespace fresco::align
