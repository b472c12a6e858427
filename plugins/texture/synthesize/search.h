#pragma once

#include "patch_kernel.h"
#include "patches.h"
#include "style_picture.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file Finds the place in the picture that looks most like each patch of the surface. Three things keep the search from using
/// the same few places everywhere: weights of keys (completeness, crowding), preferences of places (Variety) and a price for what
/// is seen nearby (NearbyUses). The synthesis calls search() once per round; the parts are declared for tests.

namespace fresco::synthesize
{

/// A query's best key.
struct Nearest
{
    std::uint32_t key = 0;
    float score = 0;  ///< Rounding may take it a little below its true value.
};

/// The kinds of features that keys and queries have.
struct FeatureSizes
{
    std::size_t squared = 0;  ///< The first features; their squared differences are summed.
    std::size_t plain = 0;    ///< The rest; their products are added to that sum.
    std::size_t all() const { return squared + plain; }
};

/// Exact search for the key of least score, by blocks of matrix products fused with the minimum: with features f and plain ones
/// p, w (|f_q - f_k|² - u + lift) + p_q·p_k = (f_q, p_q, |f_q|² - u, 1)·(-2 w f_k, p_k, w, w (|f_k|² + lift)). Among
/// equal scores the lowest key wins. Immutable, so thread-safe.
class NearestKeys
{
  public:
    /// `features`: K x sizes.all(). `weights`: the K factors w, above 0.
    NearestKeys(std::span<const float> features, const FeatureSizes& sizes, std::span<const float> weights, float lift,
                const PatchKernel& kernel);

    /// The best key of each of `count` queries (count x sizes.all()). `unavoidable`: per query, is taken off its squared
    /// distances; empty: nothing is.
    void find(const float* queries, std::size_t count, Nearest* out, std::span<const float> unavoidable = {}) const;

  private:
    const PatchKernel& kernel_;
    FeatureSizes sizes_;
    std::size_t panels_ = 0;
    std::vector<float> values_;  ///< Per panel (all() + 2) x columns.
};

/// The fastest kernel that this processor runs.
const PatchKernel& patch_kernel();

/// Smooth noise in [-1,1], one value per unit of length; `salt` chooses the field.
float smooth_noise(Vec3f at, std::uint32_t salt);

/// Random preferences of places on the surface for parts of the picture, so that a plain wall does not repeat one stroke. Surface
/// and picture have a few smooth random fields each; the preference of a patch for a key is their product, and enters the search
/// as additional features. The fields scale with strokes, so all levels have the same preferences and a finer one keeps the
/// choices of a coarser one.
class Variety
{
  public:
    static constexpr std::size_t fields = 8;

    /// `stroke_px`: width of a stroke, in texels of the grid and pixels of the picture. `amount`: standard deviation of the
    /// preferences in L*a*b*²; 0: none.
    Variety(const Patches& patches, const SurfaceGrid& grid, const StylePicture& picture, double stroke_px, double amount,
            std::uint32_t seed, const Progress& progress);

    const float* of_patch(std::size_t patch) const { return &of_patch_[patch * fields]; }
    const float* of_key(std::size_t key) const { return &of_key_[key * fields]; }
    /// Added to the mean squared difference of a patch and a key.
    float preference(std::size_t patch, std::size_t key) const;

  private:
    std::vector<float> of_patch_;
    std::vector<float> of_key_;
};

/// The place in the picture that was found for a patch.
struct Match
{
    Vec2f at;            ///< Place of the patch's center, in the level's picture.
    float distance = 0;  ///< Mean squared difference of a value of L*a*b* (see squared_gap).
    Vec2f turn{1, 0};    ///< Direction of the patch's x axis there, unit length.
    Vec3f shift{};       ///< Added to the colors there, L*a*b*.

    /// Place of a point of the patch, `offset` from its center.
    Vec2f place(Vec2f offset) const { return at + turned(offset, turn); }
};

struct SearchOptions
{
    /// α in L*a*b*² per value; smaller values use the picture more evenly. Unused parts are cheaper, but bad fits stay rare.
    double completeness = 4;
    double stroke_px = 8;    ///< Width of a stroke, in texels and in pixels of the level's picture.
    double variety = 0;      ///< See Variety; L*a*b*² per value.
    float lift = 0;          ///< Added to all distances, so that completeness counts among good fits. L*a*b*² per value.
    float repeat_cost = 60;  ///< Cost of a motif that is also seen around a patch (see NearbyUses). L*a*b*² per value.
    float weave_cost = 25;   ///< Cost of a plain place that is also used beside it.
    std::uint32_t seed = 0;  ///< Seed of Variety.
};

/// The place where the search of a round begins.
enum class Round
{
    searches,  ///< With the best of all keys for each patch.
    refines,   ///< With the matches of the last round.
};

class NearbyUses;

/// Finds the best place in the picture for every patch, in three steps: an exact search over the keys by principal components; by
/// all values, the best position between this key and its neighbors; and the places that continue those of neighboring patches,
/// which may differ more (coherence; Ashikhmin 2001, Hertzmann et al. 2001). A place costs w (max(0, d - u) + lift) + preference
/// + price, where w combines the key's completeness and crowding, 1 on average, and the price is that of a place that the surface
/// nearby shows. u is half the distance of the nearest of an eighth of the keys: where the picture has no color near the wanted
/// one, all distances are long, and without it the odd keys, which completeness makes cheap, would seem as good as the nearest
/// ones. The first step compares the best key of each of eight classes by it, for a third of the patches after another, as the
/// others are then: at first as `before`, the last round's matches (empty: all choose once without a price before); the last step
/// as the matches are then. In a picture with directions, keys are turned so that strokes run along x; a place that continues
/// another keeps its rotation on the surface, and costs more if its strokes deviate from the lines. A round that refines leaves
/// out the first two steps. `wanted`: per texel, L*a*b*. `crowding`: per key, see update_crowding. The same for any number of
/// threads. Throws Canceled.
std::vector<Match> search(const Patches& patches, const SurfaceGrid& grid, std::span<const Vec3f> wanted,
                          const StylePicture& picture, const NearbyUses& uses, const SearchOptions& options, Round round,
                          std::span<const Match> before, std::span<const float> crowding, const Progress& progress);

/// Raises each key's factor (at least 1) while the picture around it, in a square of 1 % of its area, is used more than three
/// times the average, and lowers it again below that: a price that settles over the rounds.
void update_crowding(const StylePicture& picture, std::span<const Match> matches, std::vector<float>& crowding);

}  // namespace fresco::synthesize
