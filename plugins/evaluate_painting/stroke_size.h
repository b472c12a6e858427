#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <limits>
#include <vector>

/// \file Measures how large the strokes of a painted room are on its surface, and whether they grow with the distance from the
/// cameras. The stage reports stroke_size(); size_by_distance() is declared for tests.

/// A square's mean color (L*a*b*) and the logarithm of the size of its strokes.
struct ColoredSize
{
    fresco::Vec3f color;
    double size = 0;
};

/// The same for a square on the surface, with its position and its distance from the cameras, in meters.
struct PlacedSize
{
    fresco::Vec3f point;
    double distance = 0;
    ColoredSize strokes;
};

struct SizeByDistance
{
    /// Pearson's partial correlation of size and distance, controlled for color: -1 to 1; NaN for fewer than four places or if
    /// size or distance does not vary.
    double correlation = std::numeric_limits<double>::quiet_NaN();
    /// Standard deviation of the correlation by chance, if size does not depend on distance.
    double standard_error = std::numeric_limits<double>::quiet_NaN();
    std::size_t places = 0;

    /// The number of independent places that would have this standard error.
    double independent_places() const { return 1 + 1 / (standard_error * standard_error); }
};

/// Whether strokes are larger where the surface was captured from farther away. Strokes of a picture differ in size, and
/// its parts are painted where their colors fit. The size of the picture's squares of a similar color is therefore a control
/// variable. Squares overlap, and neighboring places have similar sizes and distances: the standard error takes the
/// autocorrelations of distances and of the residual sizes into account, over classes of places equally far apart (Clifford,
/// Richardson and Hémon, "Assessing the significance of the correlation between two spatial processes", Biometrics 1989).
/// `side_m`: of the squares. `picture` must not be empty.
SizeByDistance size_by_distance(const std::vector<PlacedSize>& places, const std::vector<ColoredSize>& picture, double side_m);

/// The size of a painting's strokes.
struct StrokeSize
{
    double stroke_cm = 0;  ///< Of all swatches together; NaN for fewer than four.
    SizeByDistance by_distance;
    std::size_t swatches = 0;
};

/// Compares a painting with its picture in squares five strokes wide; `stroke_cm` is the requested width. The spectrum of L*
/// between a tenth of a stroke and a stroke (Gaussian sigmas), averaged over squares and directions, gives an autocorrelation.
/// The result is stroke_cm times the half width of the painting's autocorrelation over that of the picture's, both in strokes.
/// Broad or fine structure that is not in the picture changes it, too. `uvmaps` may be null. The same for any number of threads.
/// Throws Error for a picture that is smaller than five of its strokes or has no contrast; Canceled.
StrokeSize stroke_size(const fresco::TexturedMesh& painting, const fresco::Raster8& style, double stroke_cm,
                       const fresco::UvMaps* uvmaps, const fresco::Progress& progress);
