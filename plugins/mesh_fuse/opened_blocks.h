#pragma once

#include "depth_view.h"
#include "volume.h"

#include <cstddef>
#include <vector>

namespace fuse
{

/// Which blocks a volume needs: those within `reach_m` of a measured point along each axis.
struct OpenedBlocks
{
    double voxel_m;
    double reach_m;
    std::size_t most;  ///< Where a view needs more blocks, only so many and one are looked for.

    /// Of one view: sorted, each once.
    std::vector<BlockPlace> near(const DepthView& view) const;
};

/// Adds what is in `more`; both sorted, each once.
void unite(std::vector<BlockPlace>& places, const std::vector<BlockPlace>& more);

}  // namespace fuse
