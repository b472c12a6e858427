#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <cstddef>
#include <vector>

/// A square cut out of a surface or of a picture, seen straight on.
struct Swatch
{
    static constexpr int samples = 64;  ///< Along a side.

    fresco::RasterF light;   ///< L*, each sample the mean of its own area.
    fresco::Vec3f color;     ///< L*a*b*, the mean of points all over it.
    fresco::Vec2f texcoord;  ///< Of its middle on the surface.
    fresco::Vec3f point;     ///< The same in meters.
};

/// At most this many swatches are cut.
inline constexpr std::size_t most_swatches = 1000;

/// Squares of `side_m` all over a textured mesh, where it is flat: on one chart whose points are, on average, within a twentieth
/// of the side of a plane. Their lengths are those of the surface, however the atlas stretches it; which way they are turned is
/// arbitrary. `picture`: square RGB. The mesh must have passed check_mesh and have texcoords. The same for any number of
/// threads. Throws Canceled.
std::vector<Swatch> surface_swatches(const fresco::Mesh& mesh, const fresco::Raster8& picture, double side_m,
                                     const fresco::Progress& progress);

/// Squares of `side_px` all over a picture; none where it is smaller than that.
std::vector<Swatch> picture_swatches(const fresco::Raster8& rgb, double side_px);
