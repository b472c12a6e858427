#include "opened_blocks.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

using namespace fresco;

namespace fuse
{
namespace
{

/// A set that is sorted now and then.
class Places
{
  public:
    explicit Places(std::size_t most) : most_(most) {}

    /// False once there are more than the most.
    bool add(BlockPlace place)
    {
        places_.push_back(place);
        if (places_.size() < next_sort_)
            return true;
        sort();
        return places_.size() <= most_;
    }

    std::vector<BlockPlace> take()
    {
        sort();
        return std::move(places_);
    }

  private:
    void sort()
    {
        std::ranges::sort(places_);
        const auto rest = std::ranges::unique(places_);
        places_.erase(rest.begin(), rest.end());
        if (places_.size() > most_)
            places_.resize(most_ + 1);
        next_sort_ = 2 * places_.size() + 4096;
    }

    std::size_t most_;
    std::size_t next_sort_ = 4096;
    std::vector<BlockPlace> places_;
};

struct Box
{
    BlockPlace low, high;
    friend bool operator==(const Box&, const Box&) = default;
};

}  // namespace

std::vector<BlockPlace> OpenedBlocks::near(const DepthView& view) const
{
    const double side = block_side * voxel_m;
    const auto block = [&](Vec3d p, double shift)
    {
        const auto along = [&](double at) { return static_cast<int>(std::floor((at + shift) / side)); };
        return BlockPlace{along(p.x), along(p.y), along(p.z)};
    };
    Places places(most);
    const auto add_all = [&](const Box& box)
    {
        for (int x = box.low.x; x <= box.high.x; ++x)
            for (int y = box.low.y; y <= box.high.y; ++y)
                for (int z = box.low.z; z <= box.high.z; ++z)
                    if (!places.add({x, y, z}))
                        return false;
        return true;
    };
    Box last{{1, 1, 1}, {0, 0, 0}};
    for (int y = 0; y < view.depth.height; ++y)
        for (int x = 0; x < view.depth.width; ++x)
        {
            const float meters = view.depth.at(x, y);
            if (!(meters > 0))
                continue;
            const Vec3d point = view.camera.world_from_camera.translation + view.camera.ray(x + 0.5, y + 0.5) * double{meters};
            const Box box{block(point, -reach_m), block(point, reach_m)};
            if (box == last)
                continue;
            if (!add_all(box))
                return places.take();
            last = box;
        }
    return places.take();
}

void unite(std::vector<BlockPlace>& places, const std::vector<BlockPlace>& more)
{
    std::vector<BlockPlace> all;
    all.reserve(places.size() + more.size());
    std::ranges::set_union(places, more, std::back_inserter(all));
    places = std::move(all);
}

}  // namespace fuse
