#pragma once

#include "patch_kernel.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fresco::synthesize
{

/// A query's best key.
struct Nearest
{
    std::uint32_t key = 0;
    float score = 0;  ///< Rounding may take it a little below its true value.
};

/// What the features of keys and queries are.
struct FeatureSizes
{
    std::size_t squared = 0;  ///< The first ones: their squared differences are summed.
    std::size_t plain = 0;    ///< The rest: their products are added to that.
    std::size_t all() const { return squared + plain; }
};

/// Exact search for the key of least score, by blocks of matrix products fused with the minimum: with features f and plain ones
/// p, w (|f_q - f_k|² + lift) + p_q·p_k = (f_q, p_q, |f_q|², 1)·(-2 w f_k, p_k, w, w (|f_k|² + lift)). Of equal scores the
/// lowest key. Immutable, so thread-safe.
class NearestKeys
{
  public:
    /// `features`: K x sizes.all(). `weights`: the K factors w, above 0.
    NearestKeys(std::span<const float> features, const FeatureSizes& sizes, std::span<const float> weights, float lift,
                const PatchKernel& kernel);

    /// The best key of each of `count` queries (count x sizes.all()).
    void find(const float* queries, std::size_t count, Nearest* out) const;

  private:
    const PatchKernel& kernel_;
    FeatureSizes sizes_;
    std::size_t panels_ = 0;
    std::vector<float> values_;  ///< Per panel (all() + 2) x columns.
};

/// The fastest kernel that this processor runs.
const PatchKernel& patch_kernel();

}  // namespace fresco::synthesize
