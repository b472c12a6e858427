#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

#include <cstdint>
#include <vector>

/// The colors of a picture in CIE L*a*b*, rounded to cells of 2 units.
class Palette
{
  public:
    /// `lab`: H x W x 3.
    explicit Palette(const fresco::RasterF& lab);

    /// A color of the picture, rounded, is at most 10 units away (CIE76).
    bool is_near(fresco::Vec3f color) const;

  private:
    std::vector<std::uint8_t> cells_;  ///< 1 = the picture has it.
};
