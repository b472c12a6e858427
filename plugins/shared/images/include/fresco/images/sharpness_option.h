#pragma once

#include <fresco/image.h>
#include <fresco/option.h>

#include <vector>

namespace fresco
{

/// The option `sharpness_size_px`: declared in a stage as `SharpnessOption sharpness{this};`.
class SharpnessOption
{
  public:
    explicit SharpnessOption(Configurable* owner);

    /// Throws Error unless it is a width and a height.
    void check() const;
    /// fresco::sharpness at this size. \pre check()
    double of(const Raster8& rgb) const;

  private:
    Option<std::vector<int>> size_px_;
};

}  // namespace fresco
