#include "crops.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace fresco::optimize
{
namespace
{

/// Sums over boxes of cells of `align` x `align` pixels: which of them the mask touches.
class CellCounts
{
  public:
    CellCounts(const Raster8& mask, int align)
        : width_((mask.width + align - 1) / align), height_((mask.height + align - 1) / align)
    {
        sums_.assign(static_cast<std::size_t>(width_ + 1) * static_cast<std::size_t>(height_ + 1), 0);
        for (int y = 0; y < mask.height; ++y)
            for (int x = 0; x < mask.width; ++x)
                if (mask.at(x, y) != 0)
                    sum(x / align + 1, y / align + 1) = 1;
        for (int y = 1; y <= height_; ++y)
            for (int x = 1; x <= width_; ++x)
                sum(x, y) += sum(x - 1, y) + sum(x, y - 1) - sum(x - 1, y - 1);
    }

    PixelBox whole() const { return {0, 0, width_, height_}; }
    int count(const PixelBox& box) const
    {
        return sum(box.x1, box.y1) - sum(box.x0, box.y1) - sum(box.x1, box.y0) + sum(box.x0, box.y0);
    }
    /// The smallest box that holds what `box` holds.
    PixelBox shrunk(PixelBox box) const
    {
        while (box.x0 < box.x1 && count({box.x0, box.y0, box.x0 + 1, box.y1}) == 0)
            ++box.x0;
        while (box.x0 < box.x1 && count({box.x1 - 1, box.y0, box.x1, box.y1}) == 0)
            --box.x1;
        while (box.y0 < box.y1 && count({box.x0, box.y0, box.x1, box.y0 + 1}) == 0)
            ++box.y0;
        while (box.y0 < box.y1 && count({box.x0, box.y1 - 1, box.x1, box.y1}) == 0)
            --box.y1;
        return box;
    }

  private:
    int& sum(int x, int y)
    {
        return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ + 1) + static_cast<std::size_t>(x)];
    }
    int sum(int x, int y) const
    {
        return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ + 1) + static_cast<std::size_t>(x)];
    }

    int width_;
    int height_;
    std::vector<int> sums_;
};

class Cover
{
  public:
    Cover(const Raster8& mask, int align, int margin_px)
        : counts_(mask, align), width_(mask.width), height_(mask.height), align_(align),
          margin_((margin_px + align - 1) / align * align)
    {
    }

    std::vector<Crop> operator()()
    {
        const PixelBox all = counts_.whole();
        if (counts_.count(all) == 0)
            return {};
        split(counts_.shrunk(all));
        std::int64_t encoded = 0;
        for (const auto& crop : crops_)
            encoded += crop.encoded.area();
        const PixelBox frame{0, 0, width_, height_};
        if (10 * encoded > 9 * frame.area())
            return {{frame, frame}};
        return std::move(crops_);
    }

  private:
    /// Box of cells to pixels, `margin` wider, inside the frame.
    PixelBox pixels(const PixelBox& cells, int margin) const
    {
        return {std::max(0, cells.x0 * align_ - margin), std::max(0, cells.y0 * align_ - margin),
                std::min(width_, cells.x1 * align_ + margin), std::min(height_, cells.y1 * align_ + margin)};
    }
    std::int64_t cost(const PixelBox& cells) const { return pixels(cells, margin_).area(); }

    /// Cuts a box in two wherever that saves most, as long as it saves a twentieth of it.
    void split(const PixelBox& box)
    {
        std::int64_t best = cost(box) - cost(box) / 20;
        std::optional<std::pair<PixelBox, PixelBox>> halves;
        const auto consider = [&](const PixelBox& a, const PixelBox& b)
        {
            const auto first = counts_.shrunk(a);
            const auto second = counts_.shrunk(b);
            const auto sum = cost(first) + cost(second);
            if (sum >= best)
                return;
            best = sum;
            halves = std::pair(first, second);
        };
        for (int x = box.x0 + 1; x < box.x1; ++x)
            consider({box.x0, box.y0, x, box.y1}, {x, box.y0, box.x1, box.y1});
        for (int y = box.y0 + 1; y < box.y1; ++y)
            consider({box.x0, box.y0, box.x1, y}, {box.x0, y, box.x1, box.y1});
        if (!halves)
        {
            crops_.push_back({pixels(box, 0), pixels(box, margin_)});
            return;
        }
        split(halves->first);
        split(halves->second);
    }

    CellCounts counts_;
    int width_;
    int height_;
    int align_;
    int margin_;
    std::vector<Crop> crops_;
};

}  // namespace

std::vector<Crop> covering_crops(const Raster8& mask, int align, int margin_px)
{
    return Cover(mask, align, margin_px)();
}

}  // namespace fresco::optimize
