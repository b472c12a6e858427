#include "alignment.h"

#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

namespace fresco::align
{
namespace
{

constexpr double smallest_cell_m = 0.005;
constexpr int reach_px = 2;
constexpr double tolerance_share = 0.03;
constexpr double tolerance_m = 0.02;
constexpr double least_cosine = 0.2;

std::vector<std::uint32_t> one_per_cell(const Mesh& mesh, double cell_m)
{
    std::vector<std::pair<std::array<int, 3>, std::uint32_t>> places;  // Cell and vertex.
    places.reserve(mesh.positions.size());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
    {
        const Vec3d p = vec_cast<double>(mesh.positions[v]) * (1 / cell_m);
        places.push_back(
            {{static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)), static_cast<int>(std::floor(p.z))}, v});
    }
    std::ranges::sort(places);
    std::vector<std::uint32_t> result;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (i == 0 || places[i].first != places[i - 1].first)
            result.push_back(places[i].second);
    return result;
}

}  // namespace

std::vector<SurfacePoint> surface_points(const Mesh& mesh, std::size_t most)
{
    double cell_m = smallest_cell_m;
    auto chosen = one_per_cell(mesh, cell_m);
    while (chosen.size() > most)
        chosen = one_per_cell(mesh, cell_m *= std::numbers::sqrt2);
    const auto normals = vertex_normals(mesh);
    std::vector<SurfacePoint> points;
    points.reserve(chosen.size());
    for (const auto vertex : chosen)
        points.push_back({mesh.positions[vertex], normals[vertex]});
    return points;
}

std::vector<Sighting> sightings(const std::vector<SurfacePoint>& points, const Camera& camera, const RasterF& depth)
{
    const RigidTransform camera_from_world = camera.world_from_camera.inverse();
    const Intrinsics& k = camera.intrinsics;
    const auto is_open = [&](int column, int row, double z)
    {
        if (column < reach_px || row < reach_px || column + reach_px >= k.width || row + reach_px >= k.height)
            return false;
        for (int y = row - reach_px; y <= row + reach_px; ++y)
            for (int x = column - reach_px; x <= column + reach_px; ++x)
            {
                const auto seen = static_cast<double>(depth.at(x, y));
                if (!(std::abs(seen - z) <= tolerance_m + tolerance_share * z))
                    return false;
            }
        return true;
    };
    std::vector<Sighting> result;
    for (std::uint32_t i = 0; i < points.size(); ++i)
    {
        const Vec3d p = camera_from_world.point(vec_cast<double>(points[i].position));
        if (!(p.z > 0))
            continue;
        const double cosine = -dot(camera_from_world.direction(vec_cast<double>(points[i].normal)), p) / length(p);
        const double x = k.fx * p.x / p.z + k.cx;
        const double y = k.fy * p.y / p.z + k.cy;
        if (cosine < least_cosine || !(x >= 0 && y >= 0 && x < k.width && y < k.height))
            continue;
        if (is_open(static_cast<int>(x), static_cast<int>(y), p.z))
            result.push_back({i, static_cast<float>(cosine), vec_cast<float>(p)});
    }
    return result;
}

namespace
{

constexpr std::array<int, 3> level_heights{60, 120, 240};
constexpr double darkest = 0.03;
/// Differences of log brightness beyond this count less and less.
constexpr double robust_scale = 0.15;
/// Neighboring points see the same edges: so many count as one observation against the prior.
constexpr double alike_observations = 20;
constexpr double settled_px = 0.02;
/// Share of each step that the next one repeats: without it, groups of views that agree among themselves move slowly.
constexpr double momentum = 0.85;
/// Rounds that only solve for exposures, so that the effect of moving the cameras can be measured separately.
constexpr int exposure_rounds = 10;
/// Points with less weight from other views tell nothing.
constexpr double least_weight = 1e-3;
/// Keeps the equations solvable where a picture is even.
constexpr double tiny_share = 1e-6;
constexpr std::size_t unknowns = 7;  ///< Turn, shift, exposure.

constexpr std::size_t points_at_once = 1 << 10;

using Vector = std::array<double, unknowns>;

/// The value and its derivatives along x and y of a bilinear lookup.
struct Lookup
{
    double value = 0;
    double along_x = 0;
    double along_y = 0;
};

/// Returns nothing outside of the picture.
std::optional<Lookup> look_up(const RasterF& picture, double x, double y)
{
    x -= 0.5;
    y -= 0.5;
    if (!(x >= 0 && y >= 0 && x < picture.width - 1 && y < picture.height - 1))
        return std::nullopt;
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    const double right = x - column;
    const double down = y - row;
    const auto at = [&](int dx, int dy) { return static_cast<double>(picture.at(column + dx, row + dy)); };
    const double top = at(0, 0) + (at(1, 0) - at(0, 0)) * right;
    const double bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * right;
    return Lookup{top + (bottom - top) * down, (at(1, 0) - at(0, 0)) * (1 - down) + (at(1, 1) - at(0, 1)) * down, bottom - top};
}

struct State
{
    Vec3d turn;
    Vec3d shift;
    double exposure = 0;
    Vector speed{};

    RigidTransform motion() const { return {numerics::rotation_by(turn), shift}; }
};

class Aligner
{
  public:
    Aligner(const std::vector<AlignedView>& views, std::size_t points, const AlignmentRules& rules)
        : views_(views), rules_(rules), states_(views.size()), samples_(views.size()), sums_(points), totals_(points)
    {
        for (std::size_t v = 0; v < views.size(); ++v)
            samples_[v].resize(views[v].sightings.size());
    }

    const std::vector<State>& states() const { return states_; }

    /// Looks all sightings up; robust weights from the points' brightness as it was.
    void look(std::size_t level, bool reweigh, const Progress& progress)
    {
        parallel_items(views_.size(), 1, progress,
                       [&](std::size_t v) { look_view(v, std::min(level, views_[v].levels.size() - 1), reweigh); });
        // In the order of the views, whichever thread adds.
        parallel_for(sums_.size(), points_at_once, progress,
                     [&](std::size_t begin, std::size_t end)
                     {
                         std::ranges::fill(std::span(sums_).subspan(begin, end - begin), 0);
                         std::ranges::fill(std::span(totals_).subspan(begin, end - begin), 0);
                         for (std::size_t v = 0; v < views_.size(); ++v)
                             add_points(v, begin, end);
                     });
    }

    /// One step of every view, or only of its exposure; the largest move in pixels of the level.
    double step(std::size_t level, bool exposure_only, const Progress& progress)
    {
        std::vector<double> moved(views_.size());
        parallel_items(views_.size(), 1, progress,
                       [&](std::size_t v)
                       { moved[v] = step_view(v, std::min(level, views_[v].levels.size() - 1), exposure_only); });
        return moved.empty() ? 0 : *std::ranges::max_element(moved);
    }

    /// Mean difference to what all views see.
    double error() const
    {
        double sum = 0;
        double total = 0;
        for (std::size_t v = 0; v < views_.size(); ++v)
            for (std::size_t i = 0; i < samples_[v].size(); ++i)
                if (const auto residual = difference(v, i))
                {
                    sum += static_cast<double>(views_[v].sightings[i].weight) * std::abs(*residual);
                    total += static_cast<double>(views_[v].sightings[i].weight);
                }
        return total > 0 ? sum / total : 0;
    }

  private:
    struct Sample
    {
        float value = 0;  ///< With the exposure.
        float weight = 0;
        float along_x = 0;
        float along_y = 0;
    };

    /// Adds what view `v` sees of the points [begin, end) to their sums.
    void add_points(std::size_t v, std::size_t begin, std::size_t end)
    {
        const auto& seen = views_[v].sightings;
        const auto first = std::ranges::lower_bound(seen, begin, {}, &Sighting::point);
        for (auto i = static_cast<std::size_t>(first - seen.begin()); i < seen.size() && seen[i].point < end; ++i)
        {
            const auto weight = static_cast<double>(samples_[v][i].weight);
            sums_[seen[i].point] += weight * static_cast<double>(samples_[v][i].value);
            totals_[seen[i].point] += weight;
        }
    }

    void look_view(std::size_t v, std::size_t level, bool reweigh)
    {
        const AlignedView& view = views_[v];
        const RasterF& picture = view.levels[level];
        const Intrinsics k = view.intrinsics.scaled_to(picture.width, picture.height);
        const RigidTransform motion = states_[v].motion();
        for (std::size_t i = 0; i < samples_[v].size(); ++i)
        {
            double robust = 1;
            if (const auto residual = reweigh ? difference(v, i) : std::nullopt)
                robust = 1 / (1 + *residual * *residual / (robust_scale * robust_scale));
            const Vec3d p = motion.point(vec_cast<double>(view.sightings[i].in_camera));
            const auto found = p.z > 0 ? look_up(picture, k.fx * p.x / p.z + k.cx, k.fy * p.y / p.z + k.cy) : std::nullopt;
            samples_[v][i] = found ? Sample{static_cast<float>(found->value + states_[v].exposure),
                                            static_cast<float>(static_cast<double>(view.sightings[i].weight) * robust),
                                            static_cast<float>(found->along_x), static_cast<float>(found->along_y)}
                                   : Sample{};
        }
    }

    /// From the mean of all views, this one included: compared with the mean of the others, two views would swap colors forever.
    /// Returns nothing if no other view sees the point.
    std::optional<double> difference(std::size_t v, std::size_t i) const
    {
        const Sample& sample = samples_[v][i];
        const auto point = views_[v].sightings[i].point;
        if (!(sample.weight > 0) || !(totals_[point] - static_cast<double>(sample.weight) > least_weight))
            return std::nullopt;
        return static_cast<double>(sample.value) - sums_[point] / totals_[point];
    }

    double step_view(std::size_t v, std::size_t level, bool exposure_only)
    {
        const AlignedView& view = views_[v];
        const RasterF& picture = view.levels[level];
        const Intrinsics k = view.intrinsics.scaled_to(picture.width, picture.height);
        State& state = states_[v];
        const RigidTransform motion = state.motion();
        std::array<double, unknowns * unknowns> normal{};
        Vector right{};
        double total = 0;
        double depth = 0;
        for (std::size_t i = 0; i < samples_[v].size(); ++i)
        {
            const auto residual = difference(v, i);
            if (!residual)
                continue;
            const Sample& sample = samples_[v][i];
            const auto weight = static_cast<double>(sample.weight);
            const Vec3d p = motion.point(vec_cast<double>(view.sightings[i].in_camera));
            const double by_x = static_cast<double>(sample.along_x) * k.fx;
            const double by_y = static_cast<double>(sample.along_y) * k.fy;
            // How the value changes with the point, and with the camera's turn and shift.
            const Vec3d slope{by_x / p.z, by_y / p.z, -(by_x * p.x + by_y * p.y) / (p.z * p.z)};
            const Vec3d by_turn = cross(p - state.shift, slope);
            const Vector gradient{by_turn.x, by_turn.y, by_turn.z, slope.x, slope.y, slope.z, 1};
            for (std::size_t a = 0; a < unknowns; ++a)
            {
                right[a] -= weight * gradient[a] * *residual;
                for (std::size_t b = 0; b <= a; ++b)
                    normal[unknowns * a + b] += weight * gradient[a] * gradient[b];
            }
            total += weight;
            depth += weight * p.z;
        }
        if (!(total > 0))
            return 0;
        if (exposure_only)
        {
            state.exposure += right[6] / normal.back();
            return 0;
        }
        const double observation = robust_scale * robust_scale * alike_observations;
        const Vector now{state.turn.x, state.turn.y, state.turn.z, state.shift.x, state.shift.y, state.shift.z, 0};
        for (std::size_t a = 0; a < 6; ++a)
        {
            const double likely = a < 3 ? rules_.likely_turn : rules_.likely_shift_m;
            normal[unknowns * a + a] += observation / (likely * likely);
            right[a] -= observation / (likely * likely) * now[a];
        }
        normal.back() *= 1 + tiny_share;
        Vector& step = right;
        numerics::solve_symmetric(normal, step);
        for (std::size_t a = 0; a < unknowns; ++a)
            state.speed[a] = momentum * state.speed[a] + step[a];
        state.turn += Vec3d{state.speed[0], state.speed[1], state.speed[2]};
        state.shift += Vec3d{state.speed[3], state.speed[4], state.speed[5]};
        state.exposure += state.speed[6];
        return k.fx * (length(Vec3d{step[0], step[1], step[2]}) + length(Vec3d{step[3], step[4], step[5]}) * total / depth);
    }

    const std::vector<AlignedView>& views_;
    AlignmentRules rules_;
    std::vector<State> states_;
    std::vector<std::vector<Sample>> samples_;
    std::vector<double> sums_;  ///< Per point.
    std::vector<double> totals_;
};

std::size_t level_count(const std::vector<AlignedView>& views)
{
    std::size_t levels = 0;
    for (const auto& view : views)
        levels = std::max(levels, view.levels.size());
    return levels;
}

double error_as_recorded(const std::vector<AlignedView>& views, std::size_t points, const AlignmentRules& rules,
                         const Progress& progress)
{
    if (views.empty())
        return 0;
    Aligner aligner(views, points, rules);
    const std::size_t finest = level_count(views) - 1;
    aligner.look(finest, false, progress);
    for (int round = 0; round < exposure_rounds; ++round)
    {
        aligner.step(finest, true, progress);
        aligner.look(finest, true, progress);
    }
    return aligner.error();
}

double moved_px(const AlignedView& view, const RigidTransform& motion)
{
    double sum = 0;
    for (const Sighting& sighting : view.sightings)
    {
        const Vec3d from = vec_cast<double>(sighting.in_camera);
        const Vec3d to = motion.point(from);
        const double dx = view.intrinsics.fx * (to.x / to.z - from.x / from.z);
        const double dy = view.intrinsics.fy * (to.y / to.z - from.y / from.z);
        sum += dx * dx + dy * dy;
    }
    return view.sightings.empty() ? 0 : std::sqrt(sum / static_cast<double>(view.sightings.size()));
}

}  // namespace

std::vector<RasterF> brightness_levels(const Raster8& rgb)
{
    RasterF gray(rgb.width, rgb.height);
    for (std::size_t i = 0; i < gray.values.size(); ++i)
        gray.values[i] = (0.299F * static_cast<float>(rgb.values[3 * i]) + 0.587F * static_cast<float>(rgb.values[3 * i + 1]) +
                          0.114F * static_cast<float>(rgb.values[3 * i + 2])) /
                         255;
    std::vector<RasterF> levels;
    for (const int height : level_heights)
        if (levels.empty() || height <= rgb.height)
        {
            const int used = std::min(height, rgb.height);
            const int width = std::max(1, static_cast<int>(std::lround(static_cast<double>(used) * rgb.width / rgb.height)));
            levels.push_back(resized(gray, width, used));
            for (float& value : levels.back().values)
                value = static_cast<float>(std::log(static_cast<double>(value) + darkest));
        }
    return levels;
}

Alignment align(const std::vector<AlignedView>& views, std::size_t points, const AlignmentRules& rules, Progress& progress)
{
    Alignment result;
    result.error_before = error_as_recorded(views, points, rules, progress);
    Aligner aligner(views, points, rules);
    const std::size_t levels = level_count(views);
    for (std::size_t level = 0; level < levels; ++level)
    {
        aligner.look(level, false, progress);
        for (int round = 0; round < rules.rounds_count; ++round)
        {
            const double moved = aligner.step(level, false, progress);
            aligner.look(level, true, progress);
            progress.progress(static_cast<double>(level) * rules.rounds_count + round + 1,
                              static_cast<double>(levels) * rules.rounds_count, "rounds");
            if (moved < settled_px)
                break;
        }
    }
    result.error_after = aligner.error();
    for (std::size_t v = 0; v < views.size(); ++v)
    {
        result.corrected_from_recorded.push_back(aligner.states()[v].motion());
        result.moved_px.push_back(moved_px(views[v], result.corrected_from_recorded.back()));
    }
    return result;
}

}  // namespace fresco::align
