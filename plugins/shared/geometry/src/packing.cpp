#include <fresco/error.h>
#include <fresco/geometry/bitmap.h>
#include <fresco/geometry/packing.h>
#include <fresco/parallel.h>

#include <cmath>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <string>

namespace fresco::geometry
{

namespace
{

constexpr int largest_grid = 1024;
/// Charts start this far (texels) inside their first cell, so that rounding texcoords to float does not move them out.
constexpr double inset_px = 1.0 / 64;
constexpr double scale_precision = 0.004;
/// Shapes of up to this many cells a side are looked for from where the last one of their size went.
constexpr int small_shape = 64;

struct Placement
{
    Cell cell;
    int quarters = 0;
};

class Packer
{
  public:
    Packer(const FlatCharts& flat, const PackOptions& options, Progress& progress)
        : options_(options), progress_(progress), corners_(flat.corners),
          lists_(Partition{flat.chart_of_face, std::vector<Vec3d>(flat.count)}.faces()),
          cell_px_((options.size_px + largest_grid - 1) / largest_grid), extent_(flat.count)
    {
        parallel_for(lists_.size(), 1, progress.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         for (auto c = begin; c < end; ++c)
                             turn(c);
                     });
        for (std::uint32_t c = 0; c < lists_.size(); ++c)
            if (!lists_[c].empty())
                order_.push_back(c);
        std::stable_sort(order_.begin(), order_.end(),
                         [&](auto a, auto b) { return extent_[a].x * extent_[a].y > extent_[b].x * extent_[b].y; });
        for (std::size_t f = 0; 3 * f < corners_.size(); ++f)
            area_ += 0.5 * std::abs(cross(corners_[3 * f + 1] - corners_[3 * f], corners_[3 * f + 2] - corners_[3 * f]));
    }

    Packing pack()
    {
        find_scale();
        Packing result;
        result.texels_per_m = scale_;
        result.used_share = area_ * scale_ * scale_ / (double(options_.size_px) * double(options_.size_px));
        result.texcoords.resize(corners_.size());
        for (const auto c : order_)
            for (const auto f : lists_[c])
                for (std::size_t k = 0; k < 3; ++k)
                    result.texcoords[3 * std::size_t{f} + k] = place(c, corners_[3 * std::size_t{f} + k]);
        return result;
    }

  private:
    void turn(std::size_t chart)
    {
        std::vector<Vec2d> points;
        points.reserve(3 * lists_[chart].size());
        for (const auto f : lists_[chart])
            points.insert(points.end(), corners_.begin() + 3 * std::ptrdiff_t{f}, corners_.begin() + 3 * std::ptrdiff_t{f} + 3);
        const double angle = smallest_box_turn(points);
        const double c = std::cos(angle);
        const double s = std::sin(angle);
        Vec2d low{1e300, 1e300};
        Vec2d high{-1e300, -1e300};
        for (auto& p : points)
        {
            p = {c * p.x - s * p.y, s * p.x + c * p.y};
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
        std::size_t i = 0;
        for (const auto f : lists_[chart])
            for (std::size_t k = 0; k < 3; ++k)
                corners_[3 * std::size_t{f} + k] = points[i++] - low;
        extent_[chart] = lists_[chart].empty() ? Vec2d{} : high - low;
    }

    /// In cells; the texel at `inset_px` is the chart's corner.
    Vec2d cells(Vec2d corner, double scale) const
    {
        return {(corner.x * scale + inset_px) / cell_px_, (corner.y * scale + inset_px) / cell_px_};
    }

    Bitmap shape(std::size_t chart, double scale) const
    {
        const auto size = cells(extent_[chart], scale);
        Bitmap bitmap(static_cast<int>(size.x + inset_px) + 1, static_cast<int>(size.y + inset_px) + 1);
        for (const auto f : lists_[chart])
        {
            Vec2d t[3];
            for (std::size_t k = 0; k < 3; ++k)
                t[k] = cells(corners_[3 * std::size_t{f} + k], scale);
            bitmap.cover(t);
        }
        return bitmap;
    }

    /// Tries to place every chart at a scale (texels per meter).
    bool fits(double scale, std::vector<Placement>& placements, std::vector<Bitmap>& shapes) const
    {
        const int grid = options_.size_px / cell_px_;
        for (const auto& extent : extent_)
            if (std::max(extent.x, extent.y) * scale > options_.size_px)
                return false;
        parallel_for(order_.size(), 16, progress_.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         progress_.check_canceled();
                         for (auto i = begin; i < end; ++i)
                             shapes[order_[i]] = shape(order_[i], scale);
                     });
        const int gap = (options_.gutter_px + cell_px_ - 1) / cell_px_;
        const int margin = (options_.gutter_px + 2 * cell_px_ - 1) / (2 * cell_px_);
        ShapeBin bin(grid, gap, margin);
        std::map<std::pair<int, int>, int> first_row;
        for (std::size_t i = 0; i < order_.size(); ++i)
        {
            if (i % 16 == 0)
                progress_.check_canceled();
            const auto& upright = shapes[order_[i]];
            std::optional<Placement> best;
            int best_top = grid + 1;
            Bitmap best_shape;
            for (int quarters = 0; quarters < 4; ++quarters)
            {
                auto turned = upright.turned(quarters);
                const bool small = turned.width() <= small_shape && turned.height() <= small_shape;
                int& start = first_row[{turned.width(), turned.height()}];
                const int from = small ? start : 0;
                const auto cell = bin.find(turned, from, best_top - turned.height());
                if (!cell)
                    continue;
                if (small && quarters < 2)
                    start = cell->y;
                best = Placement{*cell, quarters};
                best_top = cell->y + turned.height();
                best_shape = std::move(turned);
            }
            if (!best)
                return false;
            bin.put(best_shape, best->cell);
            placements[order_[i]] = *best;
        }
        return true;
    }

    void find_scale()
    {
        std::vector<Placement> tried(lists_.size());
        std::vector<Bitmap> shapes(lists_.size());
        int passes = 0;
        const auto try_scale = [&](double scale)
        {
            progress_.progress(++passes, 0, "packings");
            if (!fits(scale, tried, shapes))
                return false;
            scale_ = scale;
            placements_ = tried;
            shapes_ = shapes;
            return true;
        };
        double largest = 0;
        for (const auto& extent : extent_)
            largest = std::max({largest, extent.x, extent.y});
        double low = largest > 0 ? std::min(std::sqrt(0.7 / std::max(area_, 1e-300)), 1 / largest) * options_.size_px : 1;
        double high = low;
        if (try_scale(low))
            while (largest > 0 && high == low)
            {
                if (high = low * 1.05; try_scale(high))
                    low = high;
            }
        else
            for (double step = 0.93;; step *= 0.9)
            {
                high = low;
                low *= step;
                if (high * largest < 1)  // every chart is down to a texel
                    throw Error(fmt::format("the charts do not fit a texture of {} pixels: {} charts with a gutter of {} pixels; "
                                            "use a larger size_px, a smaller gutter_px or fewer, larger pieces of surface",
                                            options_.size_px, order_.size(), options_.gutter_px));
                if (try_scale(low))
                    break;
            }
        while (high > low * (1 + scale_precision))
        {
            const double middle = 0.5 * (low + high);
            (try_scale(middle) ? low : high) = middle;
        }
    }

    Vec2f place(std::uint32_t chart, Vec2d corner) const
    {
        const auto& placement = placements_[chart];
        const double width = shapes_[chart].width();
        const double height = shapes_[chart].height();
        const auto p = cells(corner, scale_);
        const Vec2d turned = placement.quarters == 0   ? p
                             : placement.quarters == 1 ? Vec2d{height - p.y, p.x}
                             : placement.quarters == 2 ? Vec2d{width - p.x, height - p.y}
                                                       : Vec2d{p.y, width - p.x};
        const double to_uv = static_cast<double>(cell_px_) / options_.size_px;
        return {static_cast<float>((turned.x + placement.cell.x) * to_uv),
                static_cast<float>((turned.y + placement.cell.y) * to_uv)};
    }

    PackOptions options_;
    Progress& progress_;
    Corners corners_;  ///< Turned, each chart's box beginning at the origin.
    std::vector<std::vector<std::uint32_t>> lists_;
    int cell_px_;
    std::vector<Vec2d> extent_;  ///< Of the charts' boxes, meters.
    std::vector<std::uint32_t> order_;
    double area_ = 0;
    double scale_ = 0;
    std::vector<Placement> placements_;
    std::vector<Bitmap> shapes_;
};

}  // namespace

Packing pack_charts(const FlatCharts& flat, const PackOptions& options, Progress& progress)
{
    return Packer(flat, options, progress).pack();
}

}  // namespace fresco::geometry
