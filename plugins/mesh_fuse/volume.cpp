#include "volume.h"

#include <algorithm>
#include <utility>

namespace fuse
{

Volume::Volume(double voxel_m, std::vector<BlockPlace> places)
    : voxel_m_(voxel_m), places_(std::move(places)), blocks_(places_.size())
{
}

std::size_t Volume::find(BlockPlace place) const
{
    const auto found = std::ranges::lower_bound(places_, place);
    return found == places_.end() || *found != place ? none : static_cast<std::size_t>(found - places_.begin());
}

fresco::Vec3d Volume::origin(std::size_t block) const
{
    const BlockPlace& place = places_[block];
    const double side = block_side * voxel_m_;
    return {place.x * side, place.y * side, place.z * side};
}

}  // namespace fuse
