#pragma once

#include <algorithm>
#include <cmath>

/// \file Looking up what a grid holds between its cells.

namespace fresco::numerics
{

/// Two cells of one axis and a place between them; cell i is at i.
template <class T>
struct Between
{
    int first = 0;
    int second = 0;
    T share = 0;  ///< Weight of the second.
};

/// Any place; the cells need not exist.
template <class T>
Between<T> between(T at)
{
    const int first = static_cast<int>(std::floor(at));
    return {first, first + 1, at - static_cast<T>(first)};
}

/// A place among `size` cells, moved to the nearest one outside of them, and to the first one if it is no number.
template <class Share, class T>
Between<Share> between(T at, int size)
{
    const T inside = at > 0 ? std::min(at, static_cast<T>(size - 1)) : 0;
    const int first = static_cast<int>(inside);
    return {first, std::min(first + 1, size - 1), static_cast<Share>(inside - static_cast<T>(first))};
}

/// value(column, row) of four cells, first between columns.
template <class T, class Value>
auto bilinear(const Between<T>& x, const Between<T>& y, const Value& value)
{
    const auto upper = value(x.first, y.first) * (1 - x.share) + value(x.second, y.first) * x.share;
    const auto lower = value(x.first, y.second) * (1 - x.share) + value(x.second, y.second) * x.share;
    return upper * (1 - y.share) + lower * y.share;
}

}  // namespace fresco::numerics
