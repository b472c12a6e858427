#include "alignment.h"

#include <fresco/numerics/numerics.h>
#include <fresco/numerics/wide_vectors.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
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
constexpr float robust_scale = 0.15F;
/// Neighboring points see the same edges: so many count as one observation against the prior.
constexpr double alike_observations = 20;
constexpr double settled_px = 0.02;
/// Share of each step that the next one repeats: without it, groups of views that agree among themselves move slowly.
constexpr double momentum = 0.85;
/// Rounds that only solve for exposures, so that the effect of moving the cameras can be measured separately.
constexpr int exposure_rounds = 10;
/// Points with less weight from other views tell nothing.
constexpr float least_weight = 1e-3F;
/// Keeps the equations solvable where a picture is even.
constexpr double tiny_share = 1e-6;
constexpr std::size_t unknowns = 7;  ///< Turn, shift, exposure.

constexpr std::size_t points_at_once = 1 << 10;

using namespace numerics::wide_vectors;

using Vector = std::array<double, unknowns>;

struct State
{
    Vec3d turn;
    Vec3d shift;
    double exposure = 0;
    Vector speed{};

    RigidTransform motion() const { return {numerics::rotation_by(turn), shift}; }
};

/// The sightings of a view that a level compares, an array per number and padded with some of weight 0.
struct Compared
{
    std::vector<std::uint32_t> point;
    std::vector<float> x, y, z;  ///< In the camera as recorded, meters.
    std::vector<float> angle_weight;

    std::vector<float> value;  ///< With the exposure.
    std::vector<float> weight;
    std::vector<float> along_x, along_y;  ///< How the value changes from pixel to pixel.

    std::size_t size() const { return point.size(); }
};

/// The brightness of a point as all views see it.
struct Consensus
{
    float mean = 0;
    float total = 0;  ///< Weight.
};

void load(Floats& vector, const std::vector<float>& numbers, std::size_t first)
{
    std::memcpy(&vector, &numbers[first], sizeof vector);
}

void store(const Floats& vector, std::vector<float>& numbers, std::size_t first)
{
    std::memcpy(&numbers[first], &vector, sizeof vector);
}

/// Points in a camera that moved.
void move(const Compared& seen, std::size_t first, const RigidTransform& motion, std::array<Floats, 3>& moved)
{
    std::array<Floats, 3> p;
    load(p[0], seen.x, first);
    load(p[1], seen.y, first);
    load(p[2], seen.z, first);
    const auto at = [&](int row, int column) { return static_cast<float>(motion.rotation(row, column)); };
    const Vec3f t = vec_cast<float>(motion.translation);
    moved[0] = at(0, 0) * p[0] + at(0, 1) * p[1] + at(0, 2) * p[2] + t.x;
    moved[1] = at(1, 0) * p[0] + at(1, 1) * p[1] + at(1, 2) * p[2] + t.y;
    moved[2] = at(2, 0) * p[0] + at(2, 1) * p[1] + at(2, 2) * p[2] + t.z;
}

/// Differences from the mean of all views, the sample's own included: compared with the mean of the others, two views would swap
/// colors forever. Where no other view sees the point, difference and weight are 0.
void compare(const Compared& seen, std::size_t first, const std::vector<Consensus>& points, Floats& difference, Floats& weight)
{
    Floats mean;
    Floats total;
    for (std::size_t lane = 0; lane < lanes; ++lane)
    {
        const Consensus& point = points[seen.point[first + lane]];
        mean[lane] = point.mean;
        total[lane] = point.total;
    }
    load(difference, seen.value, first);
    load(weight, seen.weight, first);
    const Ints usable = (weight > 0) & (total - weight > least_weight);
    difference = usable ? difference - mean : Floats{};
    weight = usable ? weight : Floats{};
}

/// Looks the samples up, bilinearly; those outside of the picture get no weight.
FRESCO_WIDE_VECTORS void look_up(Compared& seen, const RasterF& picture, const Intrinsics& camera, const State& state,
                                 const std::vector<Consensus>* points)
{
    const RigidTransform motion = state.motion();
    const auto fx = static_cast<float>(camera.fx);
    const auto fy = static_cast<float>(camera.fy);
    const auto left = static_cast<float>(camera.cx - 0.5);
    const auto top = static_cast<float>(camera.cy - 0.5);
    const auto last_x = static_cast<float>(picture.width - 1);
    const auto last_y = static_cast<float>(picture.height - 1);
    for (std::size_t i = 0; i < seen.size(); i += lanes)
    {
        Floats weight;
        load(weight, seen.angle_weight, i);
        if (points != nullptr)
        {
            Floats difference;
            Floats before;
            compare(seen, i, *points, difference, before);
            weight /= 1 + difference * difference * (1 / (robust_scale * robust_scale));
        }
        std::array<Floats, 3> p;
        move(seen, i, motion, p);
        Floats x = fx * p[0] / p[2] + left;
        Floats y = fy * p[1] / p[2] + top;
        const Ints inside = (p[2] > 0) & (x >= 0) & (y >= 0) & (x < last_x) & (y < last_y);
        x = inside ? x : Floats{};
        y = inside ? y : Floats{};
        const Ints column = __builtin_convertvector(x, Ints);
        const Ints row = __builtin_convertvector(y, Ints);
        x -= __builtin_convertvector(column, Floats);
        y -= __builtin_convertvector(row, Floats);
        const Ints place = row * picture.width + column;
        // A picture of one row or column has nothing inside.
        const int right = picture.width > 1 ? 1 : 0;
        const int down = picture.height > 1 ? picture.width : 0;
        Floats a, b, c, d;
        for (std::size_t lane = 0; lane < lanes; ++lane)
        {
            const float* const at = picture.values.data() + place[lane];
            a[lane] = at[0];
            b[lane] = at[right];
            c[lane] = at[down];
            d[lane] = at[down + right];
        }
        const Floats upper = a + (b - a) * x;
        const Floats lower = c + (d - c) * x;
        store(upper + (lower - upper) * y + static_cast<float>(state.exposure), seen.value, i);
        store(inside ? weight : Floats{}, seen.weight, i);
        store((b - a) * (1 - y) + (d - c) * y, seen.along_x, i);
        store(lower - upper, seen.along_y, i);
    }
}

/// The equations of a Gauss-Newton step.
struct Equations
{
    std::array<double, unknowns * unknowns> normal{};  ///< Its lower half.
    Vector right{};
    double total = 0;
    double depth = 0;  ///< Times weight.
};

FRESCO_WIDE_VECTORS void add_up(const Compared& seen, const Intrinsics& camera, const State& state,
                                const std::vector<Consensus>& points, Equations& sums)
{
    const RigidTransform motion = state.motion();
    const Vec3f shift = vec_cast<float>(state.shift);
    std::array<Floats, unknowns * unknowns> normal{};
    std::array<Floats, unknowns> right{};
    Floats total{};
    Floats depth{};
    for (std::size_t i = 0; i < seen.size(); i += lanes)
    {
        Floats difference, weight, by_x, by_y;
        compare(seen, i, points, difference, weight);
        load(by_x, seen.along_x, i);
        load(by_y, seen.along_y, i);
        std::array<Floats, 3> p;
        move(seen, i, motion, p);
        // How the value changes with the point, and with the camera's turn and shift.
        const Floats nearness = 1 / (weight > 0 ? p[2] : Floats{} + 1);
        const Floats slope_x = by_x * static_cast<float>(camera.fx) * nearness;
        const Floats slope_y = by_y * static_cast<float>(camera.fy) * nearness;
        const Floats slope_z = -(slope_x * p[0] + slope_y * p[1]) * nearness;
        const Floats x = p[0] - shift.x;
        const Floats y = p[1] - shift.y;
        const Floats z = p[2] - shift.z;
        const std::array<Floats, unknowns> gradient{y * slope_z - z * slope_y,
                                                    z * slope_x - x * slope_z,
                                                    x * slope_y - y * slope_x,
                                                    slope_x,
                                                    slope_y,
                                                    slope_z,
                                                    Floats{} + 1};
        for (std::size_t a = 0; a < unknowns; ++a)
        {
            const Floats weighted = weight * gradient[a];
            right[a] -= weighted * difference;
            for (std::size_t b = 0; b <= a; ++b)
                normal[unknowns * a + b] += weighted * gradient[b];
        }
        total += weight;
        depth += weight * p[2];
    }
    for (std::size_t lane = 0; lane < lanes; ++lane)
    {
        for (std::size_t i = 0; i < normal.size(); ++i)
            sums.normal[i] += static_cast<double>(normal[i][lane]);
        for (std::size_t i = 0; i < unknowns; ++i)
            sums.right[i] += static_cast<double>(right[i][lane]);
        sums.total += static_cast<double>(total[lane]);
        sums.depth += static_cast<double>(depth[lane]);
    }
}

class Aligner
{
  public:
    Aligner(const std::vector<AlignedView>& views, std::size_t points, const AlignmentRules& rules)
        : views_(views), rules_(rules), states_(views.size()), seen_(views.size()), points_(points)
    {
    }

    const std::vector<State>& states() const { return states_; }

    /// Goes to a level of the pictures, to compare every `distance`-th point.
    void use(std::size_t level, std::size_t distance, const Progress& progress)
    {
        level_ = level;
        distance_ = distance;
        parallel_items(views_.size(), 1, progress,
                       [&](std::size_t v)
                       {
                           Compared& seen = seen_[v] = {};
                           for (const Sighting& sighting : views_[v].sightings)
                               if (sighting.point % distance == 0)
                               {
                                   seen.point.push_back(sighting.point);
                                   seen.x.push_back(sighting.in_camera.x);
                                   seen.y.push_back(sighting.in_camera.y);
                                   seen.z.push_back(sighting.in_camera.z);
                                   seen.angle_weight.push_back(sighting.weight);
                               }
                           const std::size_t padded = (seen.size() + lanes - 1) / lanes * lanes;
                           seen.point.resize(padded, seen.point.empty() ? 0 : seen.point.back());
                           for (auto* numbers : {&seen.x, &seen.y, &seen.z, &seen.angle_weight, &seen.value, &seen.weight,
                                                 &seen.along_x, &seen.along_y})
                               numbers->resize(padded, 0.0F);
                       });
        look(false, progress);
    }

    /// Looks all sightings up; robust weights from the points' brightness as it was.
    void look(bool reweigh, const Progress& progress)
    {
        parallel_items(views_.size(), 1, progress,
                       [&](std::size_t v)
                       { look_up(seen_[v], picture(v), camera(v), states_[v], reweigh ? &points_ : nullptr); });
        // In the order of the views, whichever thread adds.
        parallel_for(points_.size(), points_at_once, progress,
                     [&](std::size_t begin, std::size_t end) { add_points(begin, end); });
    }

    /// One step of every view, or only of its exposure; the largest move in pixels of the level.
    double step(bool exposure_only, const Progress& progress)
    {
        std::vector<double> moved(views_.size());
        parallel_items(views_.size(), 1, progress, [&](std::size_t v) { moved[v] = step_view(v, exposure_only); });
        return moved.empty() ? 0 : *std::ranges::max_element(moved);
    }

    /// Mean difference to what all views see.
    double error() const
    {
        double sum = 0;
        double total = 0;
        for (const Compared& seen : seen_)
            for (std::size_t i = 0; i < seen.size(); i += lanes)
            {
                Floats difference;
                Floats weight;
                compare(seen, i, points_, difference, weight);
                for (std::size_t lane = 0; lane < lanes; ++lane)
                    if (weight[lane] > 0)
                    {
                        sum += static_cast<double>(seen.angle_weight[i + lane]) * std::abs(static_cast<double>(difference[lane]));
                        total += static_cast<double>(seen.angle_weight[i + lane]);
                    }
            }
        return total > 0 ? sum / total : 0;
    }

  private:
    const RasterF& picture(std::size_t v) const { return views_[v].levels[std::min(level_, views_[v].levels.size() - 1)]; }
    Intrinsics camera(std::size_t v) const { return views_[v].intrinsics.scaled_to(picture(v).width, picture(v).height); }

    void add_points(std::size_t begin, std::size_t end)
    {
        struct Sum
        {
            double value = 0;
            double weight = 0;
        };
        std::vector<Sum> sums(end - begin);
        for (const Compared& seen : seen_)
        {
            const auto first = std::ranges::lower_bound(seen.point, begin);
            for (auto i = static_cast<std::size_t>(first - seen.point.begin()); i < seen.size() && seen.point[i] < end; ++i)
            {
                Sum& sum = sums[seen.point[i] - begin];
                const auto weight = static_cast<double>(seen.weight[i]);
                sum.value += weight * static_cast<double>(seen.value[i]);
                sum.weight += weight;
            }
        }
        for (std::size_t i = 0; i < sums.size(); ++i)
            points_[begin + i] = {sums[i].weight > 0 ? static_cast<float>(sums[i].value / sums[i].weight) : 0,
                                  static_cast<float>(sums[i].weight)};
    }

    double step_view(std::size_t v, bool exposure_only)
    {
        State& state = states_[v];
        Equations sums;
        add_up(seen_[v], camera(v), state, points_, sums);
        if (!(sums.total > 0))
            return 0;
        auto& [normal, right, total, depth] = sums;
        if (exposure_only)
        {
            state.exposure += right[6] / normal.back();
            return 0;
        }
        // One of fewer points stands for more observations.
        const double observation = double{robust_scale} * robust_scale * alike_observations / static_cast<double>(distance_);
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
        return camera(v).fx *
               (length(Vec3d{step[0], step[1], step[2]}) + length(Vec3d{step[3], step[4], step[5]}) * total / depth);
    }

    const std::vector<AlignedView>& views_;
    AlignmentRules rules_;
    std::size_t level_ = 0;
    std::size_t distance_ = 1;
    std::vector<State> states_;
    std::vector<Compared> seen_;  ///< Per view.
    std::vector<Consensus> points_;
};

/// Small pictures need few points: every n-th, so that a point stands for some six pixels. The finest level compares all.
std::size_t distance_of_points(const std::vector<AlignedView>& views, std::size_t level, std::size_t levels)
{
    constexpr std::size_t pixels_per_point = 6;
    std::size_t sightings = 0;
    std::size_t pixels = 1;
    for (const auto& view : views)
    {
        sightings += view.sightings.size();
        pixels += view.levels[std::min(level, view.levels.size() - 1)].values.size();
    }
    return level + 1 == levels ? 1 : std::max<std::size_t>(1, pixels_per_point * sightings / pixels);
}

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
    aligner.use(finest, 1, progress);
    for (int round = 0; round < exposure_rounds; ++round)
    {
        aligner.step(true, progress);
        aligner.look(true, progress);
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
        aligner.use(level, distance_of_points(views, level, levels), progress);
        for (int round = 0; round < rules.rounds_count; ++round)
        {
            const double moved = aligner.step(false, progress);
            aligner.look(true, progress);
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
