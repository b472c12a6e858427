#include <fresco/inspection/agreement.h>

#include <fresco/evaluation/statistics.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

namespace fresco::inspect
{
namespace
{

constexpr double full_agreement = 0.01;
constexpr double no_agreement = 0.04;

/// w, x, y, z.
using Quaternion = std::array<double, 4>;

/// Shepperd, "Quaternion from rotation matrix" (1978).
Quaternion quaternion(const Mat3& r)
{
    const double trace = r(0, 0) + r(1, 1) + r(2, 2);
    const std::array<double, 4> squares{trace, r(0, 0), r(1, 1), r(2, 2)};
    const auto largest = std::ranges::max_element(squares) - squares.begin();
    Quaternion q;
    if (largest == 0)
        q = {1 + trace, r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)};
    else if (largest == 1)
        q = {r(2, 1) - r(1, 2), 1 + r(0, 0) - r(1, 1) - r(2, 2), r(0, 1) + r(1, 0), r(0, 2) + r(2, 0)};
    else if (largest == 2)
        q = {r(0, 2) - r(2, 0), r(0, 1) + r(1, 0), 1 + r(1, 1) - r(0, 0) - r(2, 2), r(1, 2) + r(2, 1)};
    else
        q = {r(1, 0) - r(0, 1), r(0, 2) + r(2, 0), r(1, 2) + r(2, 1), 1 + r(2, 2) - r(0, 0) - r(1, 1)};
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& value : q)
        value /= norm;
    return q;
}

/// The pose whose quaternion was read in the other order.
RigidTransform reordered(const RigidTransform& recorded, bool scalar_first)
{
    const auto [w, x, y, z] = quaternion(recorded.rotation);
    // Read as x y z w, the file's four numbers were x y z w; read as w x y z, they were w x y z.
    return {scalar_first ? numerics::rotation_of(x, y, z, w) : numerics::rotation_of(z, w, x, y), recorded.translation};
}

}  // namespace

RigidTransform meant(const RigidTransform& recorded, Reading reading)
{
    switch (reading)
    {
    case Reading::inverted:
        return recorded.inverse();
    case Reading::transposed:
        return {transposed(recorded.rotation), recorded.translation};
    case Reading::scalar_first:
        return reordered(recorded, true);
    case Reading::scalar_last:
        return reordered(recorded, false);
    case Reading::inverted_scalar_first:
        return reordered(recorded.inverse(), true).inverse();
    case Reading::inverted_scalar_last:
        return reordered(recorded.inverse(), false).inverse();
    default:
        return recorded;
    }
}

RigidTransform Assumption::pose(const RigidTransform& recorded) const
{
    RigidTransform pose = meant(recorded, reading);
    pose.translation = pose.translation * pose_scale;
    pose.rotation = pose.rotation * camera_turn;
    return RigidTransform{world_turn, {}} * pose;
}

Intrinsics Assumption::depth_camera(const Intrinsics& depth, const Intrinsics& color) const
{
    return scaled(by_color_camera ? color.scaled_to(depth.width, depth.height) : depth, size_scale, focal_scale);
}

Intrinsics scaled(Intrinsics camera, double size, double focal)
{
    camera.fx *= size * focal;
    camera.fy *= size * focal;
    camera.cx *= size;
    camera.cy *= size;
    return camera;
}

const std::vector<Mat3>& axis_rotations()
{
    static const std::vector<Mat3> all = []
    {
        std::vector<Mat3> turns;
        std::array<std::size_t, 3> axes{0, 1, 2};
        do
            for (const int signs : {0, 6, 1, 2, 3, 4, 5, 7})  // 6: y and z negated.
            {
                Mat3 turn;
                turn.m.fill(0);
                for (std::size_t column = 0; column < 3; ++column)
                    turn.m[3 * axes[column] + column] = (static_cast<unsigned>(signs) >> column & 1U) != 0 ? -1 : 1;
                if (determinant(turn) > 0)
                    turns.push_back(turn);
            }
        while (std::ranges::next_permutation(axes).found);
        return turns;
    }();
    return all;
}

std::string axis_names(const Mat3& turn)
{
    std::string names;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            if (turn(row, column) != 0)
                names += std::string(names.empty() ? "" : " ") + (turn(row, column) > 0 ? '+' : '-') + "xyz"[row];
    return names;
}

double usual_scale(double scale)
{
    for (const double usual : {1000.0, 0.001, 0.25, 0.2, 4.0, 5.0, 100.0, 0.01, 10.0, 0.1, 0.3048, 3.2808})
        if (std::abs(std::log(scale / usual)) < 0.06)
            return usual;
    return scale;
}

bool one_camera(const DepthView& view)
{
    const Intrinsics color = view.color.scaled_to(view.depth.width, view.depth.height);
    return std::abs(color.fx / view.depth.fx - 1) < 0.002 && std::abs(color.fy / view.depth.fy - 1) < 0.002 &&
           std::abs(color.cx - view.depth.cx) < 0.002 * view.depth.width &&
           std::abs(color.cy - view.depth.cy) < 0.002 * view.depth.width && view.depth_from_color.rotation_error() < 1e-6 &&
           length(view.depth_from_color.translation) < 1e-4;
}

std::vector<DepthSample> sample_depth(const RasterF& depth, int columns)
{
    const int step = std::max(1, depth.width / columns);
    std::vector<DepthSample> samples;
    for (int y = step / 2; y < depth.height; y += step)
        for (int x = step / 2; x < depth.width; x += step)
            if (depth.at(x, y) > 0)
                samples.push_back({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, depth.at(x, y)});
    return samples;
}

MeasuredRay measured_ray(const DepthView& view, const DepthSample& sample, const Assumption& assumption)
{
    const Intrinsics k = assumption.depth_camera(view.depth, view.color);
    auto x = static_cast<double>(sample.x);
    auto y = static_cast<double>(sample.y);
    if (assumption.upside_down)
    {
        x = view.depth.width - x;
        y = view.depth.height - y;
    }
    const Vec3d direction{(x - k.cx) / k.fx, (y - k.cy) / k.fy, 1};
    const auto depth = static_cast<double>(sample.depth);
    return {direction, assumption.along_ray ? depth / length(direction) : depth};
}

RigidTransform depth_pose(const DepthView& view, const Assumption& assumption)
{
    const RigidTransform pose = assumption.pose(view.pose);
    return assumption.by_color_camera ? pose * view.depth_from_color : pose;
}

namespace
{

constexpr float one_surface = 1.15F;

/// Measured depth of a view, looked up at any pixel under an assumption.
class MeasuredGrid
{
  public:
    MeasuredGrid(const DepthView& view, const Assumption& assumption)
        : camera_(assumption.depth_camera(view.depth, view.color)), step_(std::max(1, view.depth.width / grid_columns)),
          inverse_(view.depth.width / step_ + 1, view.depth.height / step_ + 1)
    {
        for (const DepthSample& sample : view.samples)
        {
            const MeasuredRay ray = measured_ray(view, sample, assumption);
            const Vec2d place = place_of(ray.direction);
            const auto x = static_cast<int>(std::lround(place.x));
            const auto y = static_cast<int>(std::lround(place.y));
            if (x >= 0 && y >= 0 && x < inverse_.width && y < inverse_.height)
                inverse_.at(x, y) = static_cast<float>(1 / ray.depth);
        }
    }

    /// 1 / depth in a direction of the camera's axes; 0: not measured, or between two surfaces.
    double inverse_in(Vec3d direction) const
    {
        if (!(direction.z > 0))
            return 0;
        const Vec2d place = place_of(direction * (1 / direction.z));
        if (!(place.x >= 0 && place.y >= 0 && place.x < inverse_.width - 1 && place.y < inverse_.height - 1))
            return 0;
        const auto x = numerics::between(place.x);
        const auto y = numerics::between(place.y);
        const std::array around{inverse_.at(x.first, y.first), inverse_.at(x.second, y.first), inverse_.at(x.first, y.second),
                                inverse_.at(x.second, y.second)};
        const auto [least, most] = std::ranges::minmax(around);
        if (!(least > 0))
        {
            // Close to a sample, where those around it are missing.
            constexpr double closely = 0.3;
            const double column = std::round(place.x);
            const double row = std::round(place.y);
            if (std::abs(place.x - column) > closely || std::abs(place.y - row) > closely)
                return 0;
            return double{inverse_.at(static_cast<int>(column), static_cast<int>(row))};
        }
        if (most > one_surface * least)
            return 0;
        return numerics::bilinear(x, y, [&](int column, int row) { return double{inverse_.at(column, row)}; });
    }

  private:
    /// In the grid, of a direction whose z is 1.
    Vec2d place_of(Vec3d direction) const
    {
        const double first = step_ / 2 + 0.5;
        return {(camera_.fx * direction.x + camera_.cx - first) / step_, (camera_.fy * direction.y + camera_.cy - first) / step_};
    }

    Intrinsics camera_;
    int step_;
    RasterF inverse_;
};

std::vector<FrameRatios> ratios_between(const std::vector<DepthView>& views, const Assumption& assumption, std::size_t stride)
{
    std::vector<MeasuredGrid> grids;
    std::vector<RigidTransform> poses;
    for (const DepthView& view : views)
    {
        grids.emplace_back(view, assumption);
        poses.push_back(depth_pose(view, assumption));
    }
    std::vector<FrameRatios> frames(views.size());
    for (std::size_t from = 0; from < views.size(); ++from)
        for (std::size_t to = 0; to < views.size(); ++to)
        {
            if (from == to || views[from].group != views[to].group)
                continue;
            const RigidTransform relative = poses[to].inverse() * poses[from];
            for (std::size_t i = 0; i < views[from].samples.size(); i += stride)
            {
                const MeasuredRay ray = measured_ray(views[from], views[from].samples[i], assumption);
                const Vec3d point = relative.point(ray.direction * (ray.depth * assumption.depth_scale));
                frames[from].ratios.push_back(static_cast<float>(point.z * grids[to].inverse_in(point)));
                frames[from].fronts.push_back(true);
            }
        }
    return frames;
}

FrameRatios ratios_to(const raycast::Scene& scene, const DepthView& view, const Assumption& assumption, std::size_t stride)
{
    FrameRatios frame;
    const RigidTransform pose = depth_pose(view, assumption);
    std::array<Vec3d, raycast::Scene::packet_size> directions;
    std::array<double, raycast::Scene::packet_size> depths{};
    std::array<raycast::Hit, raycast::Scene::packet_size> hits;
    for (std::size_t begin = 0; begin < view.samples.size();)
    {
        std::size_t count = 0;
        for (; begin < view.samples.size() && count < directions.size(); begin += stride, ++count)
        {
            const MeasuredRay ray = measured_ray(view, view.samples[begin], assumption);
            directions[count] = pose.direction(ray.direction);
            depths[count] = ray.depth;
        }
        scene.cast(pose.translation, std::span(directions).first(count), std::span(hits).first(count));
        for (std::size_t i = 0; i < count; ++i)
        {
            frame.ratios.push_back(hits[i].found() ? static_cast<float>(hits[i].distance / depths[i]) : 0.0F);
            frame.fronts.push_back(hits[i].front);
        }
    }
    return frame;
}

}  // namespace

std::vector<FrameRatios> depth_ratios(const raycast::Scene* scene, const std::vector<DepthView>& views,
                                      const Assumption& assumption, std::size_t stride)
{
    if (scene == nullptr)
        return ratios_between(views, assumption, stride);
    std::vector<FrameRatios> frames;
    frames.reserve(views.size());
    for (const DepthView& view : views)
        frames.push_back(ratios_to(*scene, view, assumption, stride));
    return frames;
}

namespace
{

double agreement_at(double ratio)
{
    return std::clamp((no_agreement - std::abs(ratio - 1)) / (no_agreement - full_agreement), 0.0, 1.0);
}

}  // namespace

Agreement operator+(const Agreement& a, const Agreement& b)
{
    return {a.samples + b.samples, a.agreeing + b.agreeing, a.in_front + b.in_front, a.behind + b.behind,
            a.seen_through + b.seen_through};
}

std::vector<Agreement> agreement(const std::vector<FrameRatios>& frames, double scale)
{
    std::vector<Agreement> result;
    for (const FrameRatios& frame : frames)
    {
        Agreement& sums = result.emplace_back();
        sums.samples = static_cast<double>(frame.ratios.size());
        for (const float recorded : frame.ratios)
            if (const double ratio = static_cast<double>(recorded) / scale; ratio > 0)
            {
                const double agrees = agreement_at(ratio);
                sums.agreeing += agrees;
                (ratio < 1 ? sums.in_front : sums.behind) += 1 - agrees;
                sums.seen_through += ratio * one_surface < 1 ? 1 : 0;
            }
    }
    return result;
}

Agreement total(const std::vector<Agreement>& frames)
{
    return std::accumulate(frames.begin(), frames.end(), Agreement{});
}

double best_scale(const std::vector<FrameRatios>& frames)
{
    std::vector<float> ratios;
    for (const FrameRatios& frame : frames)
        std::ranges::copy_if(frame.ratios, std::back_inserter(ratios), [](float ratio) { return ratio > 0; });
    std::ranges::sort(ratios);
    // Windows that begin at each ratio hold what agrees with their middle by half or more.
    constexpr double half = (full_agreement + no_agreement) / 2;
    constexpr auto width = static_cast<float>((1 + half) / (1 - half));
    double best = 1;
    std::ptrdiff_t most = 0;
    auto end = ratios.begin();
    for (auto begin = ratios.begin(); begin != ratios.end(); ++begin)
    {
        while (end != ratios.end() && *end <= *begin * width)
            ++end;
        if (end - begin > most)
        {
            most = end - begin;
            best = static_cast<double>(*(begin + most / 2));
        }
    }
    return best;
}

double median_error(const std::vector<FrameRatios>& frames, double scale)
{
    std::vector<double> errors;
    for (const FrameRatios& frame : frames)
        for (const float ratio : frame.ratios)
            if (ratio > 0)
                errors.push_back(std::abs(static_cast<double>(ratio) / scale - 1));
    return errors.empty() ? 1 : numerics::median(std::move(errors));
}

double front_share(const std::vector<FrameRatios>& frames, double scale)
{
    double fronts = 0;
    double all = 0;
    for (const FrameRatios& frame : frames)
        for (std::size_t i = 0; i < frame.ratios.size(); ++i)
        {
            const double agrees = agreement_at(static_cast<double>(frame.ratios[i]) / scale);
            all += agrees;
            fronts += frame.fronts[i] ? agrees : 0;
        }
    return all > 0 ? fronts / all : 1;
}

namespace
{

/// Shares of correct recordings lie above this, even with noise, holes and missing parts of the mesh.
constexpr double good_share = 0.7;
constexpr evaluation::Bootstrap bootstrap{.resamples = 400, .seed = 1};
constexpr double fewest_depths = 100;
constexpr double fewest_depths_of_frame = 8;
constexpr std::size_t fewest_frames = 3;
constexpr double explained_share = 0.6;
constexpr double explained_among_frames = 0.7;
constexpr double left_of_disagreement = 0.5;
constexpr double left_among_frames = 0.7;
constexpr double least_step_share = 0.25;
constexpr double left_by_step = 0.85;
constexpr double far_more = 2.5;
constexpr double more_by_chance = 1.25;
constexpr double similar_share = 0.05;
/// Limit for a mesh that lacks objects in front of it.
constexpr double share_of_right = 0.3;
constexpr double clear_share = 0.85;

Agreement sum_of(const std::vector<Agreement>& frames, std::span<const std::size_t> chosen)
{
    Agreement sum;
    for (const std::size_t i : chosen)
        sum = sum + frames[i];
    return sum;
}

/// Too few frames have no interval: then nearly all must agree, and have disagreed.
bool beyond_chance(const std::vector<Agreement>& before, const std::vector<Agreement>& after)
{
    const auto telling =
        std::ranges::count_if(after, [](const Agreement& frame) { return frame.covered() >= fewest_depths_of_frame; });
    if (static_cast<std::size_t>(telling) < fewest_frames)
        return total(before).share() < 0.3 && total(after).share() > 0.8;
    const auto gain = [&](std::span<const std::size_t> chosen)
    { return sum_of(after, chosen).share() - sum_of(before, chosen).share(); };
    return evaluation::bootstrap_interval(before.size(), gain, bootstrap).low > 0;
}

bool gains_most(const std::vector<Agreement>& before, const std::vector<Agreement>& after, double share, double left)
{
    const Agreement was = total(before);
    const Agreement is = total(after);
    return is.covered() >= fewest_depths && is.share() >= share && 1 - is.share() <= left * (1 - was.share()) &&
           is.agreeing >= was.agreeing && beyond_chance(before, after);
}

/// A small part may agree as recorded because a wall is where another one should be.
bool covers_more(const std::vector<Agreement>& before, const std::vector<Agreement>& after)
{
    const Agreement was = total(before);
    const Agreement is = total(after);
    const auto more = [&](std::span<const std::size_t> chosen)
    { return sum_of(after, chosen).agreeing - more_by_chance * sum_of(before, chosen).agreeing; };
    return is.covered() >= fewest_depths && is.agreeing >= far_more * was.agreeing && is.share() >= was.share() - similar_share &&
           before.size() >= fewest_frames && evaluation::bootstrap_interval(before.size(), more, bootstrap).low > 0;
}

}  // namespace

bool explains(const std::vector<Agreement>& recorded, const std::vector<Agreement>& assumed, bool by_mesh)
{
    return gains_most(recorded, assumed, by_mesh ? explained_share : explained_among_frames,
                      by_mesh ? left_of_disagreement : left_among_frames) ||
           (total(assumed).share() >= good_share && covers_more(recorded, assumed));
}

bool improves(const std::vector<Agreement>& before, const std::vector<Agreement>& after)
{
    return gains_most(before, after, least_step_share, left_by_step) || covers_more(before, after);
}

bool fits(const Agreement& sum)
{
    const double not_behind = sum.agreeing + sum.in_front;
    return sum.share() >= good_share ||
           (sum.agreeing >= share_of_right * sum.covered() && sum.agreeing >= clear_share * not_behind && not_behind > 0);
}

bool gains(const std::vector<double>& before, const std::vector<double>& after)
{
    std::vector<double> difference;
    for (std::size_t i = 0; i < before.size(); ++i)
        difference.push_back(after[i] - before[i]);
    return evaluation::bootstrap_mean(difference, bootstrap).low > 0;
}

}  // namespace fresco::inspect
