#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>

#include <string_view>

namespace fresco::recordings
{

/// Distortion of a pinhole picture by a lens, as OpenCV's and COLMAP's models OPENCV and FULL_OPENCV define it (Brown,
/// "Decentering distortion of lenses", 1966; the denominator is OpenCV's rational model), or OPENCV_FISHEYE (Kannala and Brandt,
/// "A generic camera model and calibration method for conventional, wide-angle, and fish-eye lenses", 2006). All 0: nothing.
struct Lens
{
    double k1 = 0, k2 = 0, k3 = 0;  ///< Radial, of r^2, r^4, r^6; of a fisheye, of the angle's.
    double k4 = 0, k5 = 0, k6 = 0;  ///< Radial, of the denominator; k4 of a fisheye: of the angle's eighth power.
    double p1 = 0, p2 = 0;          ///< Tangential; 0 for a fisheye.
    bool is_fisheye = false;        ///< The radius is the angle to the optical axis, times 1 + k1 angle^2 + … + k4 angle^8.

    bool distorts() const { return *this != Lens{}; }
    /// Distorts the point (x/z, y/z) = `p` of a pinhole camera, in the same units (focal length 1).
    Vec2d distorted(Vec2d p) const;
    friend bool operator==(const Lens&, const Lens&) = default;
};

/// The pinhole camera of the same size and principal point that sees only what the camera with the lens sees: its focal lengths
/// are those of `camera` times the smallest factor (0.5 to 4) that leaves no pixel without a source. Of a fisheye, the pinhole
/// camera sees at most 100° across.
/// Throws Error naming `source` if there is none, or if the lens folds the picture within it (the coefficients are wrong, or
/// those of another model).
Intrinsics pinhole_without(const Lens& lens, const Intrinsics& camera, std::string_view source);

/// The picture that the camera `pinhole` would have taken in place of `camera` with its lens; `picture` has camera's aspect, of
/// any size. Bilinear; clamped at the border.
Raster8 undistorted(const Raster8& picture, const Intrinsics& camera, const Lens& lens, const Intrinsics& pinhole);
/// Undistorts depth along the optical axis, 1 channel: nearest neighbor, so that no depth is made up between surfaces.
Raster16 undistorted_depth(const Raster16& depth, const Intrinsics& camera, const Lens& lens, const Intrinsics& pinhole);

}  // namespace fresco::recordings
