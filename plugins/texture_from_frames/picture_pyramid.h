#pragma once

#include <fresco/image.h>

#include <array>
#include <vector>

namespace fresco::from_frames
{

/// A camera picture at every size down to one of less than two pixels, each the area average of the one before. Immutable, so
/// thread-safe.
class PicturePyramid
{
  public:
    /// `rgb`: 3 channels, not empty.
    explicit PicturePyramid(const Raster8& rgb);

    int width() const { return levels_.front().width; }
    int height() const { return levels_.front().height; }

    /// RGB in [0,1] at (x, y) in pixels of the full size (pixel centers at +0.5, clamped at the borders), averaged over about
    /// `footprint` of its pixels along each side: bilinear in the two levels around it, linear between them.
    std::array<float, 3> at(double x, double y, double footprint) const;

  private:
    std::vector<RasterF> levels_;
};

}  // namespace fresco::from_frames
