#include <fresco/error.h>
#include <fresco/geometry/packing.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace fresco::geometry
{

namespace
{

using Words = std::vector<std::uint64_t>;

/// target |= source moved `by` bits toward bit 0.
void or_down(std::span<std::uint64_t> target, std::span<const std::uint64_t> source, int by)
{
    const int bits = by % 64;
    source = source.subspan(std::min(static_cast<std::size_t>(by) / 64, source.size()));
    const auto count = std::min(target.size(), source.size());
    if (count == 0)
        return;
    if (bits == 0)
    {
        for (std::size_t i = 0; i < count; ++i)
            target[i] |= source[i];
        return;
    }
    for (std::size_t i = 0; i + 1 < count; ++i)
        target[i] |= source[i] >> bits | source[i + 1] << (64 - bits);
    target[count - 1] |= source[count - 1] >> bits | (count < source.size() ? source[count] << (64 - bits) : 0);
}

/// target |= source moved `by` bits away from bit 0; by may be negative.
void or_at(std::span<std::uint64_t> target, std::span<const std::uint64_t> source, int by)
{
    if (by < 0)
        return or_down(target, source, -by);
    const auto words = static_cast<std::size_t>(by) / 64;
    const int bits = by % 64;
    for (std::size_t i = 0; i < source.size() && i + words < target.size(); ++i)
    {
        target[i + words] |= source[i] << bits;
        if (bits > 0 && i + words + 1 < target.size())
            target[i + words + 1] |= source[i] >> (64 - bits);
    }
}

typedef std::uint64_t Vector __attribute__((vector_size(16)));

/// Returns two words from bit `at` of a row on; reads a third one.
Vector words_at(const std::uint64_t* row, int at)
{
    Vector low, high;
    std::memcpy(&low, row + at / 64, sizeof low);
    std::memcpy(&high, row + at / 64 + 1, sizeof high);
    return low >> at % 64 | high << 1 << (63 - at % 64);
}

struct Run
{
    int row;
    int begin;
    int end;

    /// The largest power of two that is not longer is 2^level().
    std::size_t level() const { return static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(end - begin)) - 1); }
};

std::vector<Run> runs_of(const Bitmap& shape)
{
    std::vector<Run> runs;
    for (int y = 0; y < shape.height(); ++y)
        for (int x = 0; x < shape.width();)
        {
            const auto words = shape.row(y);
            const auto rest = words[static_cast<std::size_t>(x) / 64] >> (x % 64);
            if (rest == 0)
            {
                x = (x / 64 + 1) * 64;
                continue;
            }
            x += std::countr_zero(rest);
            int end = x;
            while (end < shape.width() && shape.get(end, y))
                ++end;
            runs.push_back({y, x, end});
            x = end;
        }
    // Widely spaced rows first: where the bin is full, a few of them already rule out every place.
    const auto rank = [](int row) { return row % 64 == 0 ? 0 : row % 8 == 0 ? 1 : 2; };
    std::stable_sort(runs.begin(), runs.end(), [&](const Run& a, const Run& b) { return rank(a.row) < rank(b.row); });
    return runs;
}

}  // namespace

Bitmap::Bitmap(int width, int height)
    : width_(width), height_(height), stride_((static_cast<std::size_t>(width) + 63) / 64),
      words_(stride_ * static_cast<std::size_t>(height), 0)
{
}

void Bitmap::set(int y, int begin, int end)
{
    begin = std::max(begin, 0);
    end = std::min(end, width_);
    const auto words = row(y);
    for (int x = begin; x < end;)
    {
        const int stop = std::min(end, (x / 64 + 1) * 64);
        const auto ones = stop - x == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << (stop - x)) - 1;
        words[static_cast<std::size_t>(x) / 64] |= ones << (x % 64);
        x = stop;
    }
}

void Bitmap::cover(std::span<const Vec2d, 3> t)
{
    const double low = std::min({t[0].y, t[1].y, t[2].y});
    const double high = std::max({t[0].y, t[1].y, t[2].y});
    // A border on a line between cells touches both sides.
    const int first = std::max(0, static_cast<int>(std::ceil(low)) - 1);
    const int last = std::min(height_ - 1, static_cast<int>(std::floor(high)));
    for (int y = first; y <= last; ++y)
    {
        const double bottom = std::max(low, static_cast<double>(y));
        const double top = std::min(high, static_cast<double>(y) + 1);
        double left = 1e300;
        double right = -1e300;
        const auto add = [&](double x)
        {
            left = std::min(left, x);
            right = std::max(right, x);
        };
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto a = t[k];
            const auto b = t[(k + 1) % 3];
            if (a.y >= bottom && a.y <= top)
                add(a.x);
            for (const double line : {bottom, top})
                if ((a.y < line) != (b.y < line))
                    add(a.x + (b.x - a.x) * ((line - a.y) / (b.y - a.y)));
        }
        if (left <= right)
            set(y, static_cast<int>(std::ceil(left)) - 1, static_cast<int>(std::floor(right)) + 1);
    }
}

Bitmap Bitmap::turned(int quarters) const
{
    if (quarters % 4 == 0)
        return *this;
    const bool swap = quarters % 2 != 0;
    Bitmap out(swap ? height_ : width_, swap ? width_ : height_);
    for (int y = 0; y < height_; ++y)
        for (std::size_t w = 0; w < stride_; ++w)
            for (auto bits = row(y)[w]; bits != 0; bits &= bits - 1)
            {
                const int x = static_cast<int>(w) * 64 + std::countr_zero(bits);
                const int to_x = quarters % 4 == 1 ? height_ - 1 - y : quarters % 4 == 2 ? width_ - 1 - x : y;
                const int to_y = quarters % 4 == 1 ? x : quarters % 4 == 2 ? height_ - 1 - y : width_ - 1 - x;
                out.row(to_y)[static_cast<std::size_t>(to_x) / 64] |= std::uint64_t{1} << (to_x % 64);
            }
    return out;
}

ShapeBin::ShapeBin(int size, int gap, int margin)
    : size_(size), gap_(gap), margin_(margin),
      levels_(static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(size))), Bitmap((size + 63) / 64 * 64 + 192, size)),
      full_(static_cast<std::size_t>(size))
{
    for (int y = 0; y < size; ++y)
    {
        levels_[0].set(y, size, levels_[0].width());
        widen(y);
    }
}

void ShapeBin::widen(int y)
{
    // The cells beyond the row count as occupied.
    const auto first = std::as_const(levels_[0]).row(y);
    Words wide(2 * first.size(), ~std::uint64_t{0});
    std::ranges::copy(first, wide.begin());
    std::size_t level = 0;
    while (std::ranges::any_of(wide, [](auto word) { return word != ~std::uint64_t{0}; }) && ++level < levels_.size())
    {
        for (std::size_t i = 0; i + 3 < first.size(); i += 2)
        {
            Vector own;
            std::memcpy(&own, &wide[i], sizeof own);
            own |= words_at(&wide[i], 1 << (level - 1));
            std::memcpy(&wide[i], &own, sizeof own);
        }
        std::copy_n(wide.begin(), first.size(), levels_[level].row(y).begin());
    }
    full_[static_cast<std::size_t>(y)] = level;
}

std::optional<Cell> ShapeBin::find(const Bitmap& shape, int first_row, int end_row) const
{
    const int last_x = size() - margin_ - shape.width();
    const int last_y = std::min(size() - margin_ - shape.height(), end_row - 1);
    if (last_x < margin_)
        return std::nullopt;
    const auto runs = runs_of(shape);
    std::vector<Vector> closed(static_cast<std::size_t>(last_x) / 128 + 1, ~Vector{});
    for (int x = margin_; x <= last_x; ++x)
        closed[static_cast<std::size_t>(x) / 128][x / 64 % 2] &= ~(std::uint64_t{1} << (x % 64));

    auto blocked = closed;
    for (int y = std::max(first_row, margin_); y <= last_y; ++y)
    {
        const auto is_full = [&](const Run& run)
        { return run.level() >= full_[static_cast<std::size_t>(y) + static_cast<std::size_t>(run.row)]; };
        if (std::ranges::any_of(runs, is_full))
            continue;
        blocked = closed;
        for (const Run& run : runs)
        {
            const auto level = run.level();
            const auto* const from = levels_[level].row(y + run.row).data();
            auto everywhere = ~Vector{};
            for (std::size_t i = 0; i < blocked.size(); ++i)
                everywhere &= blocked[i] |= words_at(from + 2 * i, run.begin) | words_at(from + 2 * i, run.end - (1 << level));
            if ((everywhere[0] & everywhere[1]) == ~std::uint64_t{0})
                break;
        }
        for (std::size_t i = 0; i < 2 * blocked.size(); ++i)
            if (const auto word = blocked[i / 2][i % 2]; word != ~std::uint64_t{0})
                return Cell{static_cast<int>(i) * 64 + std::countr_one(word), y};
    }
    return std::nullopt;
}

void ShapeBin::put(const Bitmap& shape, Cell place)
{
    Words wide((static_cast<std::size_t>(shape.width() + 2 * gap_) + 63) / 64);
    for (int y = 0; y < shape.height(); ++y)
    {
        std::fill(wide.begin(), wide.end(), 0);
        for (int k = 0; k <= 2 * gap_; ++k)
            or_at(wide, shape.row(y), k);
        const int from = std::max(0, place.y + y - gap_);
        const int to = std::min(size() - 1, place.y + y + gap_);
        for (int at = from; at <= to; ++at)
            or_at(levels_[0].row(at), wide, place.x - gap_);
    }
    for (int y = std::max(0, place.y - gap_); y < std::min(size(), place.y + shape.height() + gap_); ++y)
        widen(y);
}

namespace
{

/// Andrew's monotone chain, counter-clockwise, no three points on a line.
std::vector<Vec2d> convex_hull(std::vector<Vec2d> points)
{
    std::sort(points.begin(), points.end(), [](Vec2d a, Vec2d b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 3)
        return points;
    std::vector<Vec2d> hull;
    const auto add = [&](Vec2d p, std::size_t keep)
    {
        while (hull.size() > keep && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
            hull.pop_back();
        hull.push_back(p);
    };
    for (const auto p : points)
        add(p, 1);
    const auto lower = hull.size();
    for (auto p = points.rbegin() + 1; p != points.rend(); ++p)
        add(*p, lower);
    hull.pop_back();
    return hull;
}

}  // namespace

double smallest_box_turn(std::vector<Vec2d> points)
{
    const auto hull = convex_hull(std::move(points));
    if (hull.size() < 2)
        return 0;
    double best_area = std::numeric_limits<double>::infinity();
    double best_turn = 0;
    // One side of the smallest box lies on a side of the hull (Freeman and Shapira 1975).
    for (std::size_t i = 0; i < hull.size(); ++i)
    {
        const auto along = normalized(hull[(i + 1) % hull.size()] - hull[i]);
        FlatBox box;
        for (const auto p : hull)
            box.add({dot(along, p), cross(along, p)});
        const double area = box.size().x * box.size().y;
        if (area < best_area)
        {
            best_area = area;
            best_turn = -std::atan2(along.y, along.x);
        }
    }
    return best_turn;
}

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
        : options_(options), progress_(progress), corners_(flat.corners), lists_(flat.faces()),
          cell_px_((options.size_px + largest_grid - 1) / largest_grid), extent_(lists_.size())
    {
        parallel_items(lists_.size(), 1, progress, [&](std::size_t c) { turn(c); });
        for (std::uint32_t c = 0; c < lists_.size(); ++c)
            if (!lists_[c].empty())
                order_.push_back(c);
        std::stable_sort(order_.begin(), order_.end(),
                         [&](auto a, auto b) { return extent_[a].x * extent_[a].y > extent_[b].x * extent_[b].y; });
        for (std::size_t f = 0; 3 * f < corners_.size(); ++f)
            area_ += 0.5 * std::abs(cross(corners_[3 * f + 1] - corners_[3 * f], corners_[3 * f + 2] - corners_[3 * f]));
    }

    std::vector<Vec2f> pack()
    {
        find_scale();
        std::vector<Vec2f> texcoords(corners_.size());
        for (const auto c : order_)
            for (const auto f : lists_[c])
                for (std::size_t k = 0; k < 3; ++k)
                    texcoords[3 * std::size_t{f} + k] = place(c, corners_[3 * std::size_t{f} + k]);
        return texcoords;
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
        for (auto& p : points)
            p = {c * p.x - s * p.y, s * p.x + c * p.y};
        const FlatBox box(points);
        std::size_t i = 0;
        for (const auto f : lists_[chart])
            for (std::size_t k = 0; k < 3; ++k)
                corners_[3 * std::size_t{f} + k] = points[i++] - box.low;
        extent_[chart] = lists_[chart].empty() ? Vec2d{} : box.size();
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
        parallel_items(order_.size(), 16, progress_, [&](std::size_t i) { shapes[order_[i]] = shape(order_[i], scale); });
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
                                            "use a larger size_px or fewer, larger pieces of surface",
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
    std::vector<Vec2d> extent_;  ///< Sizes of the charts' boxes, meters.
    std::vector<std::uint32_t> order_;
    double area_ = 0;
    double scale_ = 0;
    std::vector<Placement> placements_;
    std::vector<Bitmap> shapes_;
};

}  // namespace

std::vector<Vec2f> pack_charts(const FlatCharts& flat, const PackOptions& options, Progress& progress)
{
    return Packer(flat, options, progress).pack();
}

}  // namespace fresco::geometry
