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
    NearbyUses() = default;
    /// `stroke_px`: width of a stroke, in texels of the grid and pixels of the picture.
    NearbyUses(const Patches& patches, const SurfaceGrid& grid, const StylePicture& picture, double stroke_px,
               const Progress& progress);

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
        float beside = 0;  ///< Uses directly beside, among these.
    };
    class Map;

    /// Matches with the squares of the picture that they are in. Refers to them.
    struct Placed
    {
        std::span<const Match> matches;    ///< Per patch, as they are now; empty: nothing is used.
        std::vector<std::uint32_t> cells;  ///< Per patch.
    };
    Placed placed(std::span<const Match> matches) const;

  private:
    struct Block
    {
        int x, y, z;
        std::size_t first;  ///< First of its patches, in order().
    };

    /// For each block those within some blocks' distance, itself included, ascending.
    struct Neighbors
    {
        std::vector<std::size_t> first;
        std::vector<std::uint32_t> blocks;
        std::span<const std::uint32_t> of(std::uint32_t block) const
        {
            return std::span(blocks).subspan(first[block], first[block + 1] - first[block]);
        }
    };
    Neighbors within(int distance, const Progress& progress) const;

    /// The square that a place is in if it were `shift` squares further right and down.
    std::uint32_t cell(Vec2f at, float shift) const
    {
        return static_cast<std::uint32_t>(at.y / cell_px_ + shift) * static_cast<std::uint32_t>(columns_) +
               static_cast<std::uint32_t>(at.x / cell_px_ + shift);
    }

    const Patches* patches_ = nullptr;
    float cell_px_ = 1;           ///< Side of a square of the picture: half a stroke.
    int columns_ = 0;             ///< Columns of such squares,
    int rows_ = 0;                ///< with one more all around.
    float patches_per_copy_ = 1;  ///< Patches whose centers are within a stroke's square.
    std::vector<std::uint32_t> order_;
    std::vector<std::uint32_t> block_of_;  ///< Per patch.
    std::vector<Block> blocks_;            ///< Sorted, and an end.
    Neighbors beside_;
    Neighbors around_;
    std::vector<float> motifs_;
};

/// Counts the uses around one patch after another, on one thread. Refers to both.
class NearbyUses::Map
{
  public:
    Map(const NearbyUses& uses, const Placed& placed);
    Map(const NearbyUses& uses, Placed&&) = delete;

    /// Goes to a patch: its block, those beside it (2 to 4 strokes away) and those around it (8 to 10 strokes).
    void move_to(std::size_t patch);
    /// How many copies of a place are seen there.
    Copies copies(std::size_t patch, Vec2f at) const;

  private:
    static constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();

    void move(const Neighbors& neighbors, std::uint32_t to, std::vector<std::uint32_t>& uses) const;

    const NearbyUses& uses_;
    const Placed& placed_;
    std::vector<std::uint32_t> around_;  ///< Uses of each square of the picture.
    std::vector<std::uint32_t> beside_;
    std::uint32_t block_ = nowhere;
};

}  // namespace fresco::synthesize
