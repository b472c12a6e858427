#pragma once

#include "patches.h"
#include "search.h"
#include "style_picture.h"

#include <fresco/image.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// \file Counts how often a place of the picture is used on the surface around a patch, so that the search can charge for it and
/// no motif is seen twice nearby. Patches are counted in blocks, cubes of two strokes: the work for a patch depends neither on
/// the size of the room nor on how often a place is used.

namespace fresco::synthesize
{

/// The patches of a surface in blocks, and where the picture shows a motif. Immutable, so thread-safe. Refers to the patches.
class NearbyUses
{
  public:
    /// `stroke_px`: width of a stroke, in texels of the grid and pixels of the picture.
    NearbyUses(const Patches& patches, const SurfaceGrid& grid, const StylePicture& picture, double stroke_px);

    /// All patches, block by block.
    const std::vector<std::uint32_t>& order() const { return order_; }
    /// How much of a motif the picture shows within about a stroke of a key: v / (v + the median v) of the variance of L*a*b*,
    /// 0..1.
    float motif(std::size_t key) const { return motifs_[key]; }

    /// Patches from about half a stroke around a place of the picture, in patches per copy of it. Without the patch itself and
    /// those over its center that the place continues: they are the same copy.
    struct Copies
    {
        float around = 0;
        float beside = 0;  ///< Of these.
    };
    class Map;

  private:
    struct Block
    {
        int x, y, z;
        std::size_t first;  ///< Of its patches, in order().
    };

    const Patches& patches_;
    int width_;  ///< Of the picture, in pixels.
    int height_;
    float cell_px_;
    float patches_per_copy_;  ///< That have their centers within a stroke's square.
    std::vector<std::uint32_t> order_;
    std::vector<std::uint32_t> block_of_;  ///< Per patch.
    std::vector<Block> blocks_;            ///< Sorted, and an end.
    std::vector<float> motifs_;
};

/// What is used around one patch after another, on one thread.
class NearbyUses::Map
{
  public:
    /// `matches`: per patch, as they are now; empty: nothing is used.
    Map(const NearbyUses& uses, std::span<const Match> matches);

    /// Goes to a patch: its block, those beside it (2 to 4 strokes away) and those around it (8 to 10 strokes).
    void move_to(std::size_t patch);
    /// How many copies of a place are seen there.
    Copies copies(std::size_t patch, Vec2f at) const;

  private:
    template <class Visit>
    void visit_around(const Visit& visit) const;
    std::size_t cell(Vec2f at, float shift) const;

    const NearbyUses& uses_;
    std::span<const Match> matches_;
    Raster<std::uint32_t> around_;  ///< Uses in squares of the picture that are half a stroke wide.
    Raster<std::uint32_t> beside_;
    std::uint32_t block_ = std::numeric_limits<std::uint32_t>::max();
};

}  // namespace fresco::synthesize
