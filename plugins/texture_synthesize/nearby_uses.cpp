#include "nearby_uses.h"

#include <fresco/images/filters.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace fresco::synthesize
{
namespace
{

constexpr double block_strokes = 2;
constexpr int blocks_beside = 1;
constexpr int blocks_around = 4;

template <class Block>
int blocks_between(const Block& a, const Block& b)
{
    return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

}  // namespace

NearbyUses::NearbyUses(const Patches& patches, const SurfaceGrid& grid, const StylePicture& picture, double stroke_px)
    : patches_(patches), width_(picture.lab().width), height_(picture.lab().height), cell_px_(static_cast<float>(stroke_px / 2)),
      order_(patches.count()), block_of_(patches.count()), motifs_(picture.key_count())
{
    const auto scale = static_cast<float>(1 / (block_strokes * stroke_px * grid.spacing_m()));
    std::vector<Block> places(patches.count());
    std::size_t covers = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
    {
        const Vec3f at = patches[i].center * scale;
        const auto number = [](float v) { return static_cast<int>(std::floor(v)); };
        places[i] = {number(at.x), number(at.y), number(at.z), i};
        covers += patches.covers(patches[i].texel).size();
    }
    const auto side = static_cast<double>(patches.side());
    patches_per_copy_ =
        static_cast<float>(static_cast<double>(covers) / static_cast<double>(std::max<std::size_t>(1, places.size())) *
                           stroke_px * stroke_px / (side * side));
    std::ranges::sort(places, {}, [](const Block& b) { return std::tuple(b.x, b.y, b.z, b.first); });
    for (std::size_t n = 0; n < places.size(); ++n)
    {
        const Block& place = places[n];
        const Block* const last = blocks_.empty() ? nullptr : &blocks_.back();
        if (last == nullptr || last->x != place.x || last->y != place.y || last->z != place.z)
            blocks_.push_back({place.x, place.y, place.z, n});
        order_[n] = static_cast<std::uint32_t>(place.first);
        block_of_[place.first] = static_cast<std::uint32_t>(blocks_.size() - 1);
    }
    blocks_.push_back({0, 0, 0, places.size()});

    const RasterF variance = local_variance(picture.lab(), stroke_px / 2);
    for (std::size_t key = 0; key < motifs_.size(); ++key)
        motifs_[key] = variance.at(static_cast<int>(picture.key(key).x), static_cast<int>(picture.key(key).y));
    std::vector<float> sorted = motifs_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    for (float& v : motifs_)
        v = v > 0 ? v / (v + *middle) : 0;
}

NearbyUses::Map::Map(const NearbyUses& uses, std::span<const Match> matches)
    : uses_(uses), matches_(matches), around_(static_cast<int>(static_cast<float>(uses.width_) / uses.cell_px_) + 3,
                                              static_cast<int>(static_cast<float>(uses.height_) / uses.cell_px_) + 3),
      beside_(around_.width, around_.height)
{
}

/// Calls visit(match, whether its block is the own one or beside it).
template <class Visit>
void NearbyUses::Map::visit_around(const Visit& visit) const
{
    const Block& middle = uses_.blocks_[block_];
    const auto end = uses_.blocks_.end() - 1;
    for (int x = middle.x - blocks_around; x <= middle.x + blocks_around; ++x)
        for (int y = middle.y - blocks_around; y <= middle.y + blocks_around; ++y)
        {
            const auto place = [](const Block& b) { return std::tuple(b.x, b.y, b.z); };
            auto found =
                std::ranges::lower_bound(uses_.blocks_.begin(), end, std::tuple(x, y, middle.z - blocks_around), {}, place);
            for (; found != end && place(*found) <= std::tuple(x, y, middle.z + blocks_around); ++found)
            {
                const bool is_beside = blocks_between(*found, middle) <= blocks_beside;
                for (std::size_t n = found->first; n < (found + 1)->first; ++n)
                    visit(matches_[uses_.order_[n]], is_beside);
            }
        }
}

/// The cells that hold `at` if it is `shift` cells further right and down.
std::size_t NearbyUses::Map::cell(Vec2f at, float shift) const
{
    return static_cast<std::size_t>(at.y / uses_.cell_px_ + shift) * static_cast<std::size_t>(around_.width) +
           static_cast<std::size_t>(at.x / uses_.cell_px_ + shift);
}

void NearbyUses::Map::move_to(std::size_t patch)
{
    if (matches_.empty() || uses_.block_of_[patch] == block_)
        return;
    block_ = uses_.block_of_[patch];
    std::ranges::fill(around_.values, 0U);
    std::ranges::fill(beside_.values, 0U);
    visit_around(
        [&](const Match& match, bool is_beside)
        {
            ++around_.values[cell(match.at, 1)];
            beside_.values[cell(match.at, 1)] += is_beside ? 1 : 0;
        });
}

NearbyUses::Copies NearbyUses::Map::copies(std::size_t patch, Vec2f at) const
{
    if (matches_.empty())
        return {};
    const std::size_t first = cell(at, 0.5F);
    const auto width = static_cast<std::size_t>(around_.width);
    std::uint32_t around = 0;
    std::uint32_t beside = 0;
    const std::array cells{first, first + 1, first + width, first + width + 1};
    for (const std::size_t c : cells)
    {
        around += around_.values[c];
        beside += beside_.values[c];
    }
    if (around == 0)
        return {};
    // A patch may reach beyond the blocks that are counted.
    for (const std::uint32_t other : uses_.patches_.covers(uses_.patches_[patch].texel))
    {
        const Match& match = matches_[other];
        const Vec2f offset = uses_.patches_.offset(other, uses_.patches_[patch].center);
        if (std::ranges::find(cells, cell(match.at, 1)) != cells.end() &&
            (other == patch || length(match.place(offset) - at) <= 0.5F * length(offset)))
        {
            const int away = blocks_between(uses_.blocks_[uses_.block_of_[other]], uses_.blocks_[block_]);
            around -= away <= blocks_around ? 1 : 0;
            beside -= away <= blocks_beside ? 1 : 0;
        }
    }
    return {static_cast<float>(around) / uses_.patches_per_copy_, static_cast<float>(beside) / uses_.patches_per_copy_};
}

}  // namespace fresco::synthesize
