#include "plane_segments.h"

#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

using namespace fresco;
using geometry::none;

namespace
{

/// Sums over the faces of a plane from which the plane that fits best follows.
class PlaneFit
{
  public:
    void add(Vec3d point, Vec3d normal, double area)
    {
        ++count_;
        area_ += area;
        normal_ += normal * area;
        point_ += point * area;
        const std::array<double, 3> p{point.x, point.y, point.z};
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                square_[3 * i + j] += area * p[i] * p[j];
    }

    double area() const { return area_; }
    Vec3d middle() const { return point_ * (1 / area_); }

    /// The direction of least spread, by inverse iteration from the mean normal: the plane of least squared distance. A few faces
    /// of a noisy scan are as thick as they are wide, so theirs is the mean normal.
    Vec3d normal() const
    {
        constexpr std::size_t few = 200;
        const Vec3d mean = normalized(normal_);
        if (count_ < few)
            return mean;
        const Vec3d at = middle();
        const std::array<double, 3> m{at.x, at.y, at.z};
        std::array<double, 9> spread{};
        double trace = 0;
        for (std::size_t i = 0; i < 3; ++i)
        {
            for (std::size_t j = 0; j < 3; ++j)
                spread[3 * i + j] = square_[3 * i + j] / area_ - m[i] * m[j];
            trace += spread[4 * i];
        }
        if (!(trace > 0))
            return mean;
        // A little on the diagonal keeps it definite where the piece is exactly plane.
        constexpr double regular = 1e-6;
        constexpr int rounds = 6;
        for (std::size_t i = 0; i < 3; ++i)
            spread[4 * i] += regular * trace;
        Vec3d direction = mean;
        for (int round = 0; round < rounds; ++round)
        {
            std::array<double, 9> matrix = spread;
            std::array<double, 3> right{direction.x, direction.y, direction.z};
            numerics::solve_symmetric(matrix, right);
            direction = normalized(Vec3d{right[0], right[1], right[2]});
        }
        return dot(direction, mean) < 0 ? -direction : direction;
    }

  private:
    std::size_t count_ = 0;
    double area_ = 0;
    Vec3d normal_;
    Vec3d point_;
    std::array<double, 9> square_{};
};

std::vector<std::uint32_t> flattest_first(const SmoothSurface& surface)
{
    const std::vector<Vec3d>& normals = surface.smooth_normals;
    std::vector<std::pair<int, std::uint32_t>> order;
    for (std::uint32_t f = 0; f < normals.size(); ++f)
    {
        if (!(dot(normals[f], normals[f]) > 0))
            continue;
        double agreement = 1;
        for (const std::uint32_t g : surface.neighbors[f])
            agreement = std::min(agreement, g == none ? 0.9 : dot(normals[f], normals[g]));
        // In steps, so that seeds of one flat piece are in the order of the faces.
        constexpr double steps = 1e4;
        order.emplace_back(static_cast<int>(std::lround(steps * (1 - agreement))), f);
    }
    std::ranges::sort(order);
    std::vector<std::uint32_t> seeds(order.size());
    std::ranges::transform(order, seeds.begin(), &std::pair<int, std::uint32_t>::second);
    return seeds;
}

/// Grows a segment from a face over faces that are not `taken`, and marks them.
PlaneSegment grown_from(std::uint32_t seed, const SmoothSurface& surface, std::vector<std::uint8_t>& taken)
{
    const double least_cosine = numerics::cosine_deg(20);  // Between a face's smoothed normal and the plane's.
    const std::vector<Vec3d>& normals = surface.smooth_normals;
    PlaneSegment segment;
    PlaneFit fit;
    const auto take = [&](std::uint32_t f)
    {
        taken[f] = 1;
        segment.faces.push_back(f);
        fit.add(surface.middles[f], normals[f], std::max(surface.areas[f], 1e-12));
    };
    take(seed);
    segment.normal = normals[seed];
    segment.middle = fit.middle();
    std::size_t fit_again = 16;
    for (std::size_t next = 0; next < segment.faces.size(); ++next)
    {
        if (segment.faces.size() >= fit_again)
        {
            segment.normal = fit.normal();
            segment.middle = fit.middle();
            fit_again = 2 * segment.faces.size();
        }
        for (const std::uint32_t g : surface.neighbors[segment.faces[next]])
            if (g != none && !taken[g] && dot(normals[g], segment.normal) > least_cosine &&
                std::abs(segment.distance(surface.middles[g])) < most_off_m)
                take(g);
    }
    segment.normal = fit.normal();
    segment.middle = fit.middle();
    segment.area = fit.area();
    return segment;
}

}  // namespace

Vec3d face_middle(const Mesh& mesh, std::size_t face)
{
    const auto& [a, b, c] = mesh.triangles[face];
    return (vec_cast<double>(mesh.positions[a]) + vec_cast<double>(mesh.positions[b]) + vec_cast<double>(mesh.positions[c])) *
           (1.0 / 3);
}

SmoothSurface::SmoothSurface(const Mesh& of, const Progress& progress)
    : Surface(of), middles(of.triangles.size()), smooth_normals(geometry::smoothed_normals(*this, progress))
{
    for (std::size_t f = 0; f < middles.size(); ++f)
        middles[f] = face_middle(mesh, f);
}

std::vector<PlaneSegment> plane_segments(const SmoothSurface& surface, const Progress& progress)
{
    std::vector<PlaneSegment> result;
    std::vector<std::uint8_t> taken(surface.middles.size());
    std::size_t grown = 0;
    for (const std::uint32_t seed : flattest_first(surface))
        if (!taken[seed])
        {
            constexpr std::size_t seeds_between_checks = 4096;
            if (++grown % seeds_between_checks == 0)
                progress.check_canceled();
            if (PlaneSegment segment = grown_from(seed, surface, taken); segment.area >= least_segment_m2)
                result.push_back(std::move(segment));
        }
    return result;
}

namespace
{

/// How far behind a piece of furniture its wall is.
constexpr double nearest_behind_m = 0.05;
constexpr double farthest_behind_m = 1.2;
constexpr double clearly_higher_m = 0.1;
/// Smallest area of a segment that counts as a wall behind another.
constexpr double least_area_m2 = 0.1;
constexpr double same_way_cosine = 0.9;

}  // namespace

long WallColumns::column_at(Vec3d point) const
{
    return std::lround(std::floor((dot(along, point) - first) / column_m));
}

WallColumns wall_columns(const SmoothSurface& surface, const PlaneSegment& segment)
{
    WallColumns result;
    result.segment = &segment;
    result.along = normalized(cross(Vec3d{0, 0, 1}, segment.normal));
    double least = std::numeric_limits<double>::max();
    double most = std::numeric_limits<double>::lowest();
    result.low = least;
    result.high = most;
    for (const std::uint32_t f : segment.faces)
    {
        const Vec3d middle = surface.middles[f];
        least = std::min(least, dot(result.along, middle));
        most = std::max(most, dot(result.along, middle));
        result.low = std::min(result.low, middle.z);
        result.high = std::max(result.high, middle.z);
    }
    result.first = least;
    result.columns.resize(static_cast<std::size_t>((most - least) / WallColumns::column_m) + 1);
    for (WallColumns::Column& column : result.columns)
        column.top = std::numeric_limits<double>::lowest();
    for (const std::uint32_t f : segment.faces)
    {
        const Vec3d middle = surface.middles[f];
        WallColumns::Column& column = result.columns[static_cast<std::size_t>(std::max(result.column_at(middle), 0L))];
        column.area += surface.areas[f];
        column.top = std::max(column.top, middle.z);
        column.middle += middle * surface.areas[f];
    }
    for (WallColumns::Column& column : result.columns)
        if (column.area > 0)
            column.middle = column.middle * (1 / column.area);
    return result;
}

double overtopped_share(const WallColumns& of, const std::vector<WallColumns>& all)
{
    std::vector<double> top_behind(of.columns.size(), std::numeric_limits<double>::lowest());
    for (const WallColumns& other : all)
    {
        if (other.segment == of.segment || other.segment->area < least_area_m2 ||
            dot(other.segment->normal, of.segment->normal) < same_way_cosine)
            continue;
        for (const WallColumns::Column& column : other.columns)
        {
            if (!(column.area > 0))
                continue;
            const double behind = -of.segment->distance(column.middle);
            if (behind < nearest_behind_m || behind > farthest_behind_m)
                continue;
            // Columns of both do not begin at the same place.
            const long at = of.column_at(column.middle);
            for (long i = std::max(at - 1, 0L); i <= std::min(at + 1, static_cast<long>(top_behind.size()) - 1); ++i)
                top_behind[static_cast<std::size_t>(i)] = std::max(top_behind[static_cast<std::size_t>(i)], column.top);
        }
    }
    double overtopped = 0;
    double total = 0;
    for (std::size_t i = 0; i < of.columns.size(); ++i)
    {
        total += of.columns[i].area;
        if (top_behind[i] > of.columns[i].top + clearly_higher_m)
            overtopped += of.columns[i].area;
    }
    return total > 0 ? overtopped / total : 0;
}

double backed_share(const SmoothSurface& surface, const WallColumns& of, const std::vector<PlaneSegment>& segments)
{
    constexpr double least_behind_m2 = 0.01;
    std::vector<double> behind(of.columns.size());
    for (const PlaneSegment& other : segments)
        for (const std::uint32_t f : other.faces)
        {
            const Vec3d middle = surface.middles[f];
            const double distance = -of.segment->distance(middle);
            if (distance < nearest_behind_m || distance > farthest_behind_m)
                continue;
            if (const auto at = static_cast<std::size_t>(of.column_at(middle)); at < behind.size())
                behind[at] += surface.areas[f];
        }
    double backed = 0;
    for (std::size_t i = 0; i < behind.size(); ++i)
        backed += behind[i] > least_behind_m2 ? of.columns[i].area : 0;
    return backed / of.segment->area;
}
