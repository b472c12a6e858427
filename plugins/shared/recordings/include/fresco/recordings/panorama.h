#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/image_io.h>

#include <array>
#include <filesystem>

/// \file 360° pictures and the pinhole views that they are cut into: every stage after a reader works with pinhole cameras.
///
/// A panorama here is equirectangular and shows the whole sphere, as COLMAP's model EQUIRECTANGULAR (src/colmap/sensor/models.h
/// of version 4.1) and nerfstudio's of that name say: of W x H pixels, H = W / 2, the direction (x, y, z) in OpenCV's camera axes
/// is at column (atan2(x, z) / 2 pi + 1/2) W and row (1/2 + atan2(y, hypot(x, z)) / pi) H. The camera looks along the middle of
/// the picture.

namespace fresco::recordings
{

/// The six sides of a cube: front, right, back, left, up, down; the sides are level where the panorama is.
inline constexpr int panorama_faces_count = 6;

/// One of the views that a panorama is cut into.
struct PanoramaFace
{
    Intrinsics camera;  ///< Square.
    Mat3 panorama_from_face;
};

/// The views of a panorama of this width. Each sees 96 degrees: neighbors share 6, so that what lies on the border of one is
/// inside another. A pixel in the middle of a view is as large as one of the panorama's equator.
std::array<PanoramaFace, panorama_faces_count> panorama_faces(int width);

/// Throws Error naming `file` unless the picture is twice as wide as high.
void check_panorama(const std::filesystem::path& file, const ImageHeader& header);

/// Averages the rows of a panorama, 8 bits, over as many columns as a pixel of the view up or down covers there: |tan latitude|
/// beyond 45 degrees. Without it those views would pick single pixels of the many near the poles. Do it before face_of.
void widen_at_poles(Raster8& panorama);

/// View of a panorama; bilinear, across the seam behind and over the poles.
Raster8 face_of(const Raster8& panorama, const PanoramaFace& face);

/// View of a depth panorama, 1 channel, 0 and 65535: none. A panorama has no optical axis, so that its depth is the distance
/// from the camera (nerfstudio and Blender write it so); the view's is along its axis, in the same steps. Nearest neighbor, so
/// that no depth is made up between surfaces.
Raster16 depth_face_of(const Raster16& panorama, const PanoramaFace& face);

}  // namespace fresco::recordings
