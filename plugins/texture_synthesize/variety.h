#pragma once

#include "patches.h"
#include "picture_level.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::synthesize
{

/// Smooth noise in [-1,1], one value per unit of length; `salt` chooses the field.
float smooth_noise(Vec3f at, std::uint32_t salt);

/// Which parts of the picture places of the surface prefer, so that a plain wall does not take the same stroke everywhere. Both
/// have a few smooth random fields; what a patch gains with a key is their product. It enters the search as some more features.
/// The fields are measured in strokes: all levels prefer the same, so that a finer one keeps what a coarser one chose.
class Variety
{
  public:
    static constexpr std::size_t fields = 8;

    /// `stroke_px`: how wide a stroke is, in texels of the grid and pixels of the picture. `amount`: how much of L*a*b*² a
    /// preference is worth (its deviation). 0: none.
    Variety(const Patches& patches, const SurfaceGrid& grid, const PictureLevel& picture, double stroke_px, double amount,
            std::uint32_t seed, const Progress& progress);

    const float* of_patch(std::size_t patch) const { return &of_patch_[patch * fields]; }
    const float* of_key(std::size_t key) const { return &of_key_[key * fields]; }
    /// Added to the mean squared difference of a patch and a key.
    float preference(std::size_t patch, std::size_t key) const;

  private:
    std::vector<float> of_patch_;
    std::vector<float> of_key_;
};

}  // namespace fresco::synthesize
