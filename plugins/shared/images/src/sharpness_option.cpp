#include <fresco/images/sharpness_option.h>

#include <fresco/error.h>
#include <fresco/images/sharpness.h>

#include <fmt/format.h>
#include <string>

namespace fresco
{

SharpnessOption::SharpnessOption(Configurable* owner)
    : size_px_(owner, "sharpness_size_px", std::vector<int>{320, 240}, range(8, 16'384),
               "Width and height at which sharpness is measured")
{
}

void SharpnessOption::check() const
{
    if (size_px_->size() != 2)
        throw Error(fmt::format("option \"sharpness_size_px\" has {} numbers; expected [width, height]", size_px_->size()));
}

double SharpnessOption::of(const Raster8& rgb) const
{
    return sharpness(rgb, (*size_px_)[0], (*size_px_)[1]);
}

}  // namespace fresco
