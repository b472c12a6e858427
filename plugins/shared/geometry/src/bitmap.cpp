#include <fresco/geometry/bitmap.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace fresco::geometry
{

namespace
{

using Words = std::vector<std::uint64_t>;

/// target |= source moved `by` bits toward bit 0.
void or_down(std::span<std::uint64_t> target, std::span<const std::uint64_t> source, int by)
{
    const auto words = static_cast<std::size_t>(by) / 64;
    const int bits = by % 64;
    const auto count = std::min(target.size(), source.size());
    if (words >= count)
        return;
    if (bits == 0)
    {
        for (std::size_t i = 0; i + words < count; ++i)
            target[i] |= source[i + words];
        return;
    }
    for (std::size_t i = 0; i + words + 1 < count; ++i)
        target[i] |= source[i + words] >> bits | source[i + words + 1] << (64 - bits);
    target[count - words - 1] |= source[count - 1] >> bits;
}

/// target |= source moved `by` bits away from bit 0; by may be negative.
void or_at(std::span<std::uint64_t> target, std::span<const std::uint64_t> source, int by)
{
    if (by < 0)
    {
        const auto words = static_cast<std::size_t>(-by) / 64;
        const int bits = -by % 64;
        for (std::size_t i = words; i < source.size() && i - words < target.size(); ++i)
        {
            target[i - words] |= source[i] >> bits;
            if (bits > 0 && i > words)
                target[i - words - 1] |= source[i] << (64 - bits);
        }
        return;
    }
    const auto words = static_cast<std::size_t>(by) / 64;
    const int bits = by % 64;
    for (std::size_t i = 0; i < source.size() && i + words < target.size(); ++i)
    {
        target[i + words] |= source[i] << bits;
        if (bits > 0 && i + words + 1 < target.size())
            target[i + words + 1] |= source[i] >> (64 - bits);
    }
}

struct Run
{
    int row;
    int begin;
    int length;
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
            runs.push_back({y, x, end - x});
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

ShapeBin::ShapeBin(int size, int gap, int margin) : gap_(gap), margin_(margin), occupied_(size, size) {}

std::optional<Cell> ShapeBin::find(const Bitmap& shape, int first_row, int end_row) const
{
    const int last_x = size() - margin_ - shape.width();
    const int last_y = std::min(size() - margin_ - shape.height(), end_row - 1);
    if (last_x < margin_)
        return std::nullopt;
    const auto runs = runs_of(shape);
    const auto words = static_cast<std::size_t>(last_x) / 64 + 1;
    Words allowed(words, ~std::uint64_t{0});
    allowed.back() = last_x % 64 == 63 ? ~std::uint64_t{0} : (std::uint64_t{1} << (last_x % 64 + 1)) - 1;
    for (int x = 0; x < margin_; ++x)
        allowed[static_cast<std::size_t>(x) / 64] &= ~(std::uint64_t{1} << (x % 64));

    Words blocked(words);
    Words spread;
    for (int y = std::max(first_row, margin_); y <= last_y; ++y)
    {
        for (std::size_t i = 0; i < words; ++i)
            blocked[i] = ~allowed[i];
        for (std::size_t r = 0; r < runs.size(); ++r)
        {
            // Bit p of `spread`: an occupied cell among p … p + length - 1, by doubling.
            const auto source = occupied_.row(y + runs[r].row);
            spread.assign(source.begin(), source.end());
            int reach = 1;
            for (; 2 * reach <= runs[r].length; reach *= 2)
                or_down(spread, spread, reach);
            if (reach < runs[r].length)
                or_down(spread, spread, runs[r].length - reach);
            const auto offset = static_cast<std::size_t>(runs[r].begin) / 64;
            const int bits = runs[r].begin % 64;
            bool open = false;
            for (std::size_t i = 0; i < words; ++i)
            {
                const auto low = i + offset < spread.size() ? spread[i + offset] >> bits : 0;
                const auto high = bits > 0 && i + offset + 1 < spread.size() ? spread[i + offset + 1] << (64 - bits) : 0;
                blocked[i] |= low | high;
                open = open || blocked[i] != ~std::uint64_t{0};
            }
            if (!open)
                break;
        }
        for (std::size_t i = 0; i < words; ++i)
            if (blocked[i] != ~std::uint64_t{0})
                return Cell{static_cast<int>(i) * 64 + std::countr_one(blocked[i]), y};
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
        for (int row = from; row <= to; ++row)
            or_at(occupied_.row(row), wide, place.x - gap_);
    }
    // Bits beyond the right side, which a grown shape may have set.
    if (size() % 64 != 0)
        for (int row = 0; row < size(); ++row)
            occupied_.row(row).back() &= (std::uint64_t{1} << (size() % 64)) - 1;
}

}  // namespace fresco::geometry
