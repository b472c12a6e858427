#pragma once

namespace fresco::optimize
{

/// Where StyleMesh's paper and its authors' released code differ. Nobody mixes them, so it is one option.
enum class Protocol
{
    paper,
    /// The stored values of each layer are clamped after every step, the sum of the layers never. ŵ_l of a term comes from the
    /// masks on its layer's grid. An angle passes the filter if it is below the limit, and angles are those of the smallest
    /// height, enlarged. The camera is encoded at the smallest height and its features are enlarged. Pixels without a surface
    /// show the texture's first texel. The style's sizes are the authors' (style_sizes). The views are visited in recorded order,
    /// and the last hundredth of them not at all.
    released
};

}  // namespace fresco::optimize
