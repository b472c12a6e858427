#include <fresco/geometry/overlap.h>

#include <cmath>
#include <limits>

namespace fresco::geometry
{

namespace
{

struct Box
{
    Vec2d low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    Vec2d high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    void add(Vec2d p)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
};

std::span<const Vec2d, 3> triangle(const Corners& corners, std::uint32_t face)
{
    return std::span<const Vec2d, 3>(corners.data() + 3 * static_cast<std::size_t>(face), 3);
}

/// Overlap of the shadows on the normals of a's edges; 0 as soon as one separates.
double depth_along_edges(std::span<const Vec2d, 3> of, std::span<const Vec2d, 3> a, std::span<const Vec2d, 3> b)
{
    double depth = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto edge = of[(k + 1) % 3] - of[k];
        const double norm = length(edge);
        if (!(norm > 0))
            continue;
        const Vec2d axis{-edge.y / norm, edge.x / norm};
        const auto shadow = [&](std::span<const Vec2d, 3> t)
        {
            const double s[3] = {dot(axis, t[0]), dot(axis, t[1]), dot(axis, t[2])};
            return std::pair(std::min({s[0], s[1], s[2]}), std::max({s[0], s[1], s[2]}));
        };
        const auto [a_low, a_high] = shadow(a);
        const auto [b_low, b_high] = shadow(b);
        depth = std::min({depth, a_high - b_low, b_high - a_low});
        if (depth <= 0)
            return 0;
    }
    return depth;
}

/// Faces by the cells of a square grid that their boxes touch.
struct Grid
{
    Box bounds;
    double cell = 1;
    std::size_t width = 1;
    std::size_t height = 1;

    std::size_t column(double x) const { return bin(x - bounds.low.x, width); }
    std::size_t row(double y) const { return bin(y - bounds.low.y, height); }

  private:
    std::size_t bin(double offset, std::size_t count) const
    {
        return std::min(count - 1, static_cast<std::size_t>(std::max(offset / cell, 0.0)));
    }
};

Grid make_grid(const std::vector<Box>& boxes)
{
    Grid grid;
    double sizes = 0;
    for (const auto& box : boxes)
    {
        grid.bounds.add(box.low);
        grid.bounds.add(box.high);
        sizes += std::max(box.high.x - box.low.x, box.high.y - box.low.y);
    }
    const auto extent = grid.bounds.high - grid.bounds.low;
    // Cells of a mean face's size, but no more cells than twice the faces.
    grid.cell = std::max({sizes / static_cast<double>(boxes.size()),
                          std::sqrt(extent.x * extent.y / (2.0 * static_cast<double>(boxes.size()))),
                          std::max(extent.x, extent.y) / (2.0 * static_cast<double>(boxes.size())), 1e-300});
    grid.width = static_cast<std::size_t>(extent.x / grid.cell) + 1;
    grid.height = static_cast<std::size_t>(extent.y / grid.cell) + 1;
    return grid;
}

}  // namespace

double overlap_depth(std::span<const Vec2d, 3> a, std::span<const Vec2d, 3> b)
{
    const double first = depth_along_edges(a, a, b);
    const double depth = first > 0 ? std::min(first, depth_along_edges(b, a, b)) : 0;
    return std::isfinite(depth) ? depth : 0;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> find_overlaps(const Corners& corners, std::span<const std::uint32_t> faces,
                                                                   double tolerance)
{
    if (faces.size() < 2)
        return {};
    std::vector<Box> boxes(faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (const auto p : triangle(corners, faces[i]))
            boxes[i].add(p);
    const auto grid = make_grid(boxes);

    std::vector<std::size_t> begin(grid.width * grid.height + 1, 0);
    const auto each_cell = [&](const Box& box, auto&& act)
    {
        for (auto y = grid.row(box.low.y); y <= grid.row(box.high.y); ++y)
            for (auto x = grid.column(box.low.x); x <= grid.column(box.high.x); ++x)
                act(y * grid.width + x);
    };
    for (const auto& box : boxes)
        each_cell(box, [&](std::size_t cell) { ++begin[cell + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::uint32_t> items(begin.back());
    auto next = begin;
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
        each_cell(boxes[i], [&](std::size_t cell) { items[next[cell]++] = i; });

    std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
    for (std::size_t cell = 0; cell + 1 < begin.size(); ++cell)
        for (auto i = begin[cell]; i < begin[cell + 1]; ++i)
            for (auto j = i + 1; j < begin[cell + 1]; ++j)
            {
                const auto& a = boxes[items[i]];
                const auto& b = boxes[items[j]];
                const Vec2d low{std::max(a.low.x, b.low.x), std::max(a.low.y, b.low.y)};
                if (low.x >= std::min(a.high.x, b.high.x) || low.y >= std::min(a.high.y, b.high.y))
                    continue;
                // Of the cells that hold both, only the one with the corner of the common box looks at them.
                if (grid.row(low.y) * grid.width + grid.column(low.x) != cell)
                    continue;
                const auto fa = faces[items[i]];
                const auto fb = faces[items[j]];
                if (overlap_depth(triangle(corners, fa), triangle(corners, fb)) > tolerance)
                    found.emplace_back(std::min(fa, fb), std::max(fa, fb));
            }
    std::sort(found.begin(), found.end());
    return found;
}

}  // namespace fresco::geometry
