#include "edges.h"

#include "assumption.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>

namespace fresco::inspect
{
namespace
{

/// Fewer tell nothing.
constexpr std::size_t fewest_points = 20;
constexpr std::size_t rough_stride = 4;

/// Bilinear; false outside.
bool look_up(const RasterF& raster, double x, double y, double& value)
{
    x -= 0.5;
    y -= 0.5;
    if (!(x >= 0 && y >= 0 && x < raster.width - 1 && y < raster.height - 1))
        return false;
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    const double right = x - column;
    const double down = y - row;
    const auto at = [&](int dx, int dy) { return static_cast<double>(raster.at(column + dx, row + dy)); };
    value = (at(0, 0) * (1 - right) + at(1, 0) * right) * (1 - down) + (at(0, 1) * (1 - right) + at(1, 1) * right) * down;
    return true;
}

double response(const EdgeView& view, const CameraChange& change, std::size_t stride = 1)
{
    if (view.outline.size() < fewest_points)
        return 0;
    const Intrinsics k = changed(view.camera, change);
    double sum = 0;
    for (std::size_t i = 0; i < view.outline.size(); i += stride)
    {
        const Vec2d point = view.outline[i];
        double x = k.fx * point.x + k.cx;
        double y = k.fy * point.y + k.cy;
        if (change.upside_down)
        {
            x = k.width - x;
            y = k.height - y;
        }
        if (double strength = 0; look_up(*view.edges, x, y, strength))
            sum += strength - 1;
    }
    return sum / static_cast<double>((view.outline.size() + stride - 1) / stride);
}

double mean_response(const std::vector<EdgeView>& views, const CameraChange& change, std::size_t stride)
{
    double sum = 0;
    std::size_t telling = 0;
    for (const EdgeView& view : views)
    {
        sum += response(view, change, stride);
        telling += view.outline.size() >= fewest_points;
    }
    return views.empty() ? 0 : sum / std::max(static_cast<double>(telling), 0.5 * static_cast<double>(views.size()));
}

}  // namespace

Intrinsics changed(const Intrinsics& recorded, const CameraChange& change)
{
    Intrinsics k = scaled(recorded, change.size_scale, change.focal_scale);
    k.cx += change.shift_x * k.width;
    k.cy += change.shift_y * k.height;
    return k;
}

void add_outline(EdgeView& view, const std::vector<Vec3d>& points)
{
    for (const Vec3d p : points)
        if (p.z > 0)
            view.outline.push_back({p.x / p.z, p.y / p.z});
}

std::vector<double> edge_responses(const std::vector<EdgeView>& views, const CameraChange& change)
{
    std::vector<double> responses;
    for (const EdgeView& view : views)
        responses.push_back(response(view, change));
    return responses;
}

double edge_response(const std::vector<EdgeView>& views, const CameraChange& change)
{
    return mean_response(views, change, 1);
}

CameraChange best_change(const std::vector<EdgeView>& views, const CameraChange& start, const Progress& progress)
{
    CameraChange best = start;
    const auto search =
        [&](double furthest_focal, double focal_step, double furthest_shift, double shift_step, std::size_t stride)
    {
        double most = mean_response(views, best, stride);
        const CameraChange middle = best;
        const auto focal_steps = static_cast<int>(std::lround(furthest_focal / focal_step));
        const auto shift_steps = static_cast<int>(std::lround(furthest_shift / shift_step));
        const auto focals = 2 * static_cast<std::size_t>(focal_steps) + 1;
        std::vector<CameraChange> bests(focals);
        std::vector<double> mosts(focals, -1);
        parallel_for(focals, 1, progress.threads(),
                     [&](std::size_t focal, std::size_t)
                     {
                         progress.check_canceled();
                         for (int y = -shift_steps; y <= shift_steps; ++y)
                             for (int x = -shift_steps; x <= shift_steps; ++x)
                             {
                                 CameraChange change = middle;
                                 change.focal_scale *= std::exp(focal_step * (static_cast<int>(focal) - focal_steps));
                                 change.shift_x += shift_step * x;
                                 change.shift_y += shift_step * y;
                                 if (const double found = mean_response(views, change, stride); found > mosts[focal])
                                 {
                                     mosts[focal] = found;
                                     bests[focal] = change;
                                 }
                             }
                     });
        for (std::size_t i = 0; i < focals; ++i)
            if (mosts[i] > most)
            {
                most = mosts[i];
                best = bests[i];
            }
    };
    search(color_focal_reach, 0.03, 0.04, 0.01, rough_stride);
    search(0.03, 0.01, 0.008, 0.004, 1);
    return best;
}

}  // namespace fresco::inspect
