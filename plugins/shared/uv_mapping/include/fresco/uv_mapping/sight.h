#pragma once

namespace fresco
{

/// Nearer surfaces are the scanner's own noise, not something a camera saw.
inline constexpr double nearest_surface_m = 0.05;

/// What a camera's ray ends on.
enum class Sight
{
    nothing,
    surface,    ///< The front of a face, at least nearest_surface_m away.
    back_face,  ///< The back of a face: nothing behind it is seen either.
    too_near    ///< The front of a face nearer than nearest_surface_m along the optical axis.
};

/// Judges what was met at a depth (meters along the optical axis).
Sight sight(bool front, double depth);

}  // namespace fresco
