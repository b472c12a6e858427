#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <limits>
#include <vector>

/// A square's mean color (L*a*b*) and the logarithm of the size of its strokes.
struct ColoredSize
{
    fresco::Vec3f color;
    double size = 0;
};

/// The same of a square on the surface: where it is and how far away the cameras saw it, in meters.
struct PlacedSize
{
    fresco::Vec3f point;
    double distance = 0;
    ColoredSize strokes;
};

struct SizeByDistance
{
    /// Pearson's partial correlation of size and distance, less what color explains of both: -1 to 1; NaN for fewer than four
    /// places or where size or distance does not vary.
    double correlation = std::numeric_limits<double>::quiet_NaN();
    /// How far chance takes the correlation from 0 where size does not depend on distance.
    double standard_error = std::numeric_limits<double>::quiet_NaN();
    std::size_t places = 0;

    /// So many independent places would have this standard error.
    double independent_places() const { return 1 + 1 / (standard_error * standard_error); }
};

/// Whether strokes are larger where the surface was captured from farther away. Strokes of a picture differ in size, and the
/// picture's parts lie where their colors fit. So the size that the picture's squares of a similar color have is a control
/// variable. Squares overlap, and both sizes and distances are alike at places close to each other: the standard error has the
/// autocorrelations of distances and of what is left of sizes over classes of places as far apart (Clifford, Richardson and
/// Hémon, "Assessing the significance of the correlation between two spatial processes", Biometrics 1989). `side_m`: of the
/// squares. `picture` may not be empty.
SizeByDistance size_by_distance(const std::vector<PlacedSize>& places, const std::vector<ColoredSize>& picture, double side_m);
