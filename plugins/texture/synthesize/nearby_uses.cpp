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

NearbyUses::NearbyUses(const Patches& patches, const SurfaceGrid& grid, const StylePicture& picture, double stroke_px,
                       const Progress& progress)
    : patches_(&patches), cell_px_(static_cast<float>(stroke_px / 2)),
      columns_(static_cast<int>(static_cast<float>(picture.lab().width) / cell_px_) + 3),
      rows_(static_cast<int>(static_cast<float>(picture.lab().height) / cell_px_) + 3), order_(patches.count()),
      block_of_(patches.count()), motifs_(picture.key_count())
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
    beside_ = within(blocks_beside, progress);
    around_ = within(blocks_around, progress);

    const RasterF variance = local_variance(picture.lab(), stroke_px / 2);
    for (std::size_t key = 0; key < motifs_.size(); ++key)
        motifs_[key] = variance.at(static_cast<int>(picture.key(key).x), static_cast<int>(picture.key(key).y));
    std::vector<float> sorted = motifs_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    for (float& v : motifs_)
        v = v > 0 ? v / (v + *middle) : 0;
}

NearbyUses::Neighbors NearbyUses::within(int distance, const Progress& progress) const
{
    Neighbors result;
    const auto end = blocks_.end() - 1;
    const auto place = [](const Block& b) { return std::tuple(b.x, b.y, b.z); };
    for (auto middle = blocks_.begin(); middle != end; ++middle)
    {
        if (result.first.size() % 4096 == 0)
            progress.check_canceled();
        result.first.push_back(result.blocks.size());
        for (int x = middle->x - distance; x <= middle->x + distance; ++x)
            for (int y = middle->y - distance; y <= middle->y + distance; ++y)
            {
                auto found = std::ranges::lower_bound(blocks_.begin(), end, std::tuple(x, y, middle->z - distance), {}, place);
                for (; found != end && place(*found) <= std::tuple(x, y, middle->z + distance); ++found)
                    result.blocks.push_back(static_cast<std::uint32_t>(found - blocks_.begin()));
            }
    }
    result.first.push_back(result.blocks.size());
    return result;
}

NearbyUses::Placed NearbyUses::placed(std::span<const Match> matches) const
{
    Placed result{matches, std::vector<std::uint32_t>(matches.size())};
    std::ranges::transform(matches, result.cells.begin(), [this](const Match& match) { return cell(match.at, 1); });
    return result;
}

NearbyUses::Map::Map(const NearbyUses& uses, const Placed& placed)
    : uses_(uses), placed_(placed), around_(static_cast<std::size_t>(uses.columns_) * static_cast<std::size_t>(uses.rows_)),
      beside_(around_.size())
{
}

/// Adds the blocks that are near `to` and not near the block so far, and takes off those that no longer are: mostly few.
void NearbyUses::Map::move(const Neighbors& neighbors, std::uint32_t to, std::vector<std::uint32_t>& uses) const
{
    const auto add = [&](std::uint32_t block, std::uint32_t times)
    {
        for (std::size_t n = uses_.blocks_[block].first; n < uses_.blocks_[block + 1].first; ++n)
            uses[placed_.cells[uses_.order_[n]]] += times;
    };
    constexpr std::uint32_t minus_one = ~0U;
    const auto before = block_ == nowhere ? std::span<const std::uint32_t>() : neighbors.of(block_);
    auto old = before.begin();
    for (const std::uint32_t block : neighbors.of(to))
    {
        for (; old != before.end() && *old < block; ++old)
            add(*old, minus_one);
        if (old != before.end() && *old == block)
            ++old;
        else
            add(block, 1);
    }
    for (; old != before.end(); ++old)
        add(*old, minus_one);
}

void NearbyUses::Map::move_to(std::size_t patch)
{
    const std::uint32_t to = uses_.block_of_[patch];
    if (placed_.matches.empty() || to == block_)
        return;
    move(uses_.beside_, to, beside_);
    move(uses_.around_, to, around_);
    block_ = to;
}

NearbyUses::Copies NearbyUses::Map::copies(std::size_t patch, Vec2f at) const
{
    if (placed_.matches.empty())
        return {};
    const std::uint32_t first = uses_.cell(at, 0.5F);
    const auto columns = static_cast<std::uint32_t>(uses_.columns_);
    std::uint32_t around = 0;
    std::uint32_t beside = 0;
    const std::array cells{first, first + 1, first + columns, first + columns + 1};
    for (const std::uint32_t c : cells)
    {
        around += around_[c];
        beside += beside_[c];
    }
    if (around == 0)
        return {};
    // A patch may reach beyond the blocks that are counted.
    const Patches& patches = *uses_.patches_;
    for (const std::uint32_t other : patches.covers(patches[patch].texel))
    {
        if (std::ranges::find(cells, placed_.cells[other]) == cells.end())
            continue;
        const Vec2f offset = patches.offset(other, patches[patch].center);
        if (other == patch || length(placed_.matches[other].place(offset) - at) <= 0.5F * length(offset))
        {
            const int away = blocks_between(uses_.blocks_[uses_.block_of_[other]], uses_.blocks_[block_]);
            around -= away <= blocks_around ? 1 : 0;
            beside -= away <= blocks_beside ? 1 : 0;
        }
    }
    return {static_cast<float>(around) / uses_.patches_per_copy_, static_cast<float>(beside) / uses_.patches_per_copy_};
}

}  // namespace fresco::synthesize
