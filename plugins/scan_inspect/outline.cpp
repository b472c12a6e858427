#include "outline.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco::inspect
{
namespace
{

constexpr std::size_t rows_per_block = 8;
constexpr double step_share = 0.08;
/// Keeps noise in the dark from counting as edges.
constexpr double darkest = 16;
/// Frames with less of an outline count less.
constexpr double telling_points = 50;
/// More of a frame's outline tells nothing new.
constexpr std::size_t most_points = 400;

RasterF log_brightness(const Raster8& rgb)
{
    RasterF gray(rgb.width, rgb.height);
    for (std::size_t i = 0; i < gray.values.size(); ++i)
        gray.values[i] = static_cast<float>(
            std::log(0.299 * rgb.values[3 * i] + 0.587 * rgb.values[3 * i + 1] + 0.114 * rgb.values[3 * i + 2] + darkest));
    return gray;
}

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

}  // namespace

RasterF mesh_depth(const raycast::Scene& scene, const Camera& camera, const Progress& progress)
{
    const auto width = static_cast<std::size_t>(camera.intrinsics.width);
    RasterF depth(camera.intrinsics.width, camera.intrinsics.height);
    parallel_for(static_cast<std::size_t>(depth.height), rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<raycast::Hit> hits((end - begin) * width);
                     scene.cast_rows(camera, static_cast<int>(begin), static_cast<int>(end), hits);
                     for (std::size_t i = 0; i < hits.size(); ++i)
                         if (hits[i].found())
                             depth.values[begin * width + i] = static_cast<float>(hits[i].distance);
                 });
    return depth;
}

Raster8 outline(const RasterF& depth)
{
    Raster8 result(depth.width, depth.height);
    for (int y = 1; y < depth.height - 1; ++y)
        for (int x = 1; x < depth.width - 1; ++x)
        {
            const auto near = static_cast<double>(depth.at(x, y));
            if (near <= 0)
                continue;
            for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}})
            {
                const auto far = static_cast<double>(depth.at(x + dx, y + dy));
                if (far <= 0 || far > near * (1 + step_share))
                    result.at(x, y) = 1;
            }
        }
    return result;
}

RasterF edge_strength(const Raster8& rgb)
{
    const RasterF gray = log_brightness(rgb);
    RasterF gradient(gray.width, gray.height);
    double sum = 0;
    for (int y = 1; y < gray.height - 1; ++y)
        for (int x = 1; x < gray.width - 1; ++x)
            gradient.at(x, y) = std::hypot(gray.at(x + 1, y) - gray.at(x - 1, y), gray.at(x, y + 1) - gray.at(x, y - 1));
    RasterF strength(gray.width, gray.height);
    for (int y = 0; y < gray.height; ++y)
        for (int x = 0; x < gray.width; ++x)
        {
            float most = 0;
            for (int ny = std::max(0, y - 1); ny <= std::min(gray.height - 1, y + 1); ++ny)
                for (int nx = std::max(0, x - 1); nx <= std::min(gray.width - 1, x + 1); ++nx)
                    most = std::max(most, gradient.at(nx, ny));
            strength.at(x, y) = most;
            sum += static_cast<double>(most);
        }
    const double mean = sum / static_cast<double>(strength.values.size());
    for (float& value : strength.values)
        value = mean > 0 ? static_cast<float>(static_cast<double>(value) / mean) : 1;
    return strength;
}

void find_outline(const raycast::Scene& scene, const Convention& convention, OutlinedFrame& frame, const Progress& progress)
{
    const Camera camera{frame.camera.intrinsics, convention.correct(frame.camera.world_from_camera)};
    const RasterF depth = mesh_depth(scene, camera, progress);
    const Raster8 outlined = outline(depth);
    frame.outline.clear();
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (outlined.at(x, y) != 0)
                frame.outline.push_back(camera.world_from_camera.translation +
                                        camera.ray(x + 0.5, y + 0.5) * static_cast<double>(depth.at(x, y)));
    const std::size_t stride = (frame.outline.size() + most_points - 1) / most_points;
    for (std::size_t i = 0; i * stride < frame.outline.size(); ++i)
        frame.outline[i] = frame.outline[i * stride];
    if (stride > 1)
        frame.outline.resize((frame.outline.size() + stride - 1) / stride);
}

Intrinsics changed(const Intrinsics& recorded, const CameraChange& change)
{
    Intrinsics k = recorded;
    k.fx *= change.focal_scale;
    k.fy *= change.focal_scale;
    k.cx += change.shift_x * k.width;
    k.cy += change.shift_y * k.height;
    return k;
}

namespace
{

/// The outlines in the pinholes' plane (x / z, y / z), and the edges they are to meet.
struct FlatFrame
{
    Intrinsics intrinsics;
    const RasterF* edges = nullptr;
    std::vector<Vec2d> outline;
};

std::vector<FlatFrame> flatten(const std::vector<OutlinedFrame>& frames, const Convention& convention)
{
    std::vector<FlatFrame> flat;
    for (const OutlinedFrame& frame : frames)
    {
        if (frame.edges.empty())
            continue;
        flat.push_back({frame.camera.intrinsics, &frame.edges, {}});
        const RigidTransform camera_from_world = convention.correct(frame.camera.world_from_camera).inverse();
        for (const Vec3d point : frame.outline)
            if (const Vec3d p = camera_from_world.point(point); p.z > 0)
                flat.back().outline.push_back({p.x / p.z, p.y / p.z});
    }
    return flat;
}

/// Mean over frames; those with few points count less, and at least half of the frames count.
class FrameMean
{
  public:
    void add(double sum, std::size_t points)
    {
        ++frames_;
        if (points == 0)
            return;
        const double weight = std::min(1.0, static_cast<double>(points) / telling_points);
        sum_ += weight * sum / static_cast<double>(points);
        weights_ += weight;
    }
    double value() const { return frames_ == 0 ? 0 : sum_ / std::max(weights_, 0.5 * static_cast<double>(frames_)); }

  private:
    double sum_ = 0;
    double weights_ = 0;
    std::size_t frames_ = 0;
};

bool strength_at(const FlatFrame& frame, const Intrinsics& k, Vec2d point, double& strength)
{
    return look_up(*frame.edges, k.fx * point.x + k.cx, k.fy * point.y + k.cy, strength);
}

double response(const std::vector<FlatFrame>& frames, const CameraChange& change)
{
    FrameMean mean;
    for (const FlatFrame& frame : frames)
    {
        const Intrinsics k = changed(frame.intrinsics, change);
        double sum = 0;
        for (const Vec2d point : frame.outline)
            if (double strength = 0; strength_at(frame, k, point, strength))
                sum += strength - 1;
        mean.add(sum, frame.outline.size());
    }
    return mean.value();
}

}  // namespace

double edge_response(const std::vector<OutlinedFrame>& frames, const Convention& convention, const CameraChange& change)
{
    return response(flatten(frames, convention), change);
}

std::pair<double, double> compare_responses(const std::vector<OutlinedFrame>& frames, const Convention& convention,
                                            const CameraChange& change)
{
    FrameMean without;
    FrameMean with;
    for (const FlatFrame& frame : flatten(frames, convention))
    {
        const Intrinsics k = changed(frame.intrinsics, change);
        double sum_without = 0;
        double sum_with = 0;
        std::size_t points = 0;
        for (const Vec2d point : frame.outline)
            if (double one = 0, other = 0;
                strength_at(frame, frame.intrinsics, point, one) && strength_at(frame, k, point, other))
            {
                sum_without += one - 1;
                sum_with += other - 1;
                ++points;
            }
        without.add(sum_without, points);
        with.add(sum_with, points);
    }
    return {without.value(), with.value()};
}

CameraChange best_change(const std::vector<OutlinedFrame>& frames, const Convention& convention, const Progress& progress)
{
    const auto flat = flatten(frames, convention);
    CameraChange best;
    double most = response(flat, best);
    const auto search = [&](double focal_reach, double focal_step, double shift_reach, double shift_step)
    {
        const CameraChange middle = best;
        const auto focal_steps = static_cast<int>(std::lround(focal_reach / focal_step));
        const auto shift_steps = static_cast<int>(std::lround(shift_reach / shift_step));
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
                                 const CameraChange change{middle.focal_scale *
                                                               std::exp(focal_step * (static_cast<int>(focal) - focal_steps)),
                                                           middle.shift_x + shift_step * x, middle.shift_y + shift_step * y};
                                 if (const double found = response(flat, change); found > mosts[focal])
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
    search(color_focal_reach, 0.03, 0.04, 0.01);
    search(0.03, 0.01, 0.008, 0.004);
    return best;
}

}  // namespace fresco::inspect
