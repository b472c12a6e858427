#include <fresco/geometry/packing.h>

#include <cmath>
#include <limits>

namespace fresco::geometry
{

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
        double low_x = 1e300, high_x = -1e300, low_y = 1e300, high_y = -1e300;
        for (const auto p : hull)
        {
            const double x = dot(along, p);
            const double y = cross(along, p);
            low_x = std::min(low_x, x);
            high_x = std::max(high_x, x);
            low_y = std::min(low_y, y);
            high_y = std::max(high_y, y);
        }
        const double area = (high_x - low_x) * (high_y - low_y);
        if (area < best_area)
        {
            best_area = area;
            best_turn = -std::atan2(along.y, along.x);
        }
    }
    return best_turn;
}

}  // namespace fresco::geometry
