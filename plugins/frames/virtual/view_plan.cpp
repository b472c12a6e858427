#include "view_plan.h"

#include "free_space.h"

#include <fresco/geometry/upright.h>
#include <fresco/mesh.h>
#include <fresco/numerics/greedy_cover.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/uv_mapping/shading.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <numbers>
#include <numeric>
#include <utility>

namespace fresco::virtual_views
{
namespace
{

constexpr double tolerance_m = 1e-3;

}  // namespace

std::vector<SurfacePoint> surface_points(const Mesh& mesh, int cells_px, const Progress& progress)
{
    const auto charts = texturing::find_charts(mesh);
    const auto faces = texturing::find_texel_faces(mesh, charts, cells_px, progress);
    const auto normals = face_normals(mesh);
    std::vector<SurfacePoint> points;
    for (std::size_t cell = 0; cell < faces.face.size(); ++cell)
        if (faces.inside[cell] != 0)
            points.push_back({texturing::texel_position(mesh, faces, cell), normals[faces.face[cell]], faces.face[cell],
                              charts.of_face[faces.face[cell]], static_cast<std::uint32_t>(cell)});
    return points;
}

std::vector<std::uint32_t> visible_points(const raycast::Scene& scene, std::span<const SurfacePoint> points, Vec3d eye,
                                          std::span<const std::uint32_t> asked)
{
    std::vector<std::uint32_t> facing;
    std::vector<Vec3d> ways;
    for (const std::uint32_t number : asked)
    {
        const Vec3d toward = vec_cast<double>(points[number].position) - eye;
        if (dot(vec_cast<double>(points[number].normal), toward) >= 0 || length(toward) < nearest_surface_m)
            continue;
        facing.push_back(number);
        ways.push_back(toward);
    }
    const auto hits = hits_from(scene, eye, ways);
    std::vector<std::uint32_t> seen;
    for (std::size_t i = 0; i < hits.size(); ++i)
    {
        const raycast::Hit& hit = hits[i];
        const bool there = hit.found() && hit.front && (1 - hit.distance) * length(ways[i]) <= tolerance_m;
        if (there || hit.triangle == points[facing[i]].face)
            seen.push_back(facing[i]);
    }
    return seen;
}

namespace
{

/// Whether the point lies in a camera's picture, in a pixel that its mask does not ignore (see load_mask); it may be occluded.
bool in_picture(const Camera& camera, const Raster8& mask, Vec3f position)
{
    const Vec3d at = camera.project(vec_cast<double>(position));
    const Intrinsics& size = camera.intrinsics;
    if (!(at.z > 0 && at.x >= 0 && at.y >= 0 && at.x < size.width && at.y < size.height))
        return false;
    return mask.empty() || mask.at(static_cast<int>(at.x), static_cast<int>(at.y)) != 0;
}

using Numbers = std::vector<std::uint32_t>;

/// Points that are looked at together: neighbors in the texture, so that their rays stay together.
constexpr std::size_t block = 4096;

template <class Work>
void in_blocks(std::size_t count, const Progress& progress, const Work& work)
{
    parallel_for(count, block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     work(begin, end);
                 });
}

}  // namespace

Coverage::Coverage(const raycast::Scene& scene, std::span<const SurfacePoint> points, int cells_px, int gap)
    : scene_(scene), points_(points), cells_px_(cells_px), gap_(gap),
      point_in_(static_cast<std::size_t>(cells_px) * static_cast<std::size_t>(cells_px), nobody), painted_(points.size())
{
    for (std::size_t i = 0; i < points.size(); ++i)
        point_in_[points[i].cell] = static_cast<std::uint32_t>(i);
}

std::vector<std::uint32_t> Coverage::add(const Camera& camera, const Raster8& mask, const Progress& progress)
{
    std::vector<Numbers> found((points_.size() + block - 1) / block);
    in_blocks(points_.size(), progress,
              [&](std::size_t begin, std::size_t end)
              {
                  Numbers asked;
                  for (std::size_t i = begin; i < end; ++i)
                      if (painted_[i] == 0 && in_picture(camera, mask, points_[i].position))
                          asked.push_back(static_cast<std::uint32_t>(i));
                  found[begin / block] = visible_points(scene_, points_, camera.world_from_camera.translation, asked);
              });
    Numbers all;
    for (const Numbers& part : found)
        all.insert(all.end(), part.begin(), part.end());
    for (const std::uint32_t point : all)
        paint_around(point);
    return all;
}

void Coverage::paint_around(std::uint32_t point)
{
    const auto [chart, cell] = std::pair(points_[point].chart, static_cast<int>(points_[point].cell));
    const auto least = [&](int at) { return std::max(0, at - gap_); };
    const auto most = [&](int at) { return std::min(cells_px_ - 1, at + gap_); };
    for (int y = least(cell / cells_px_); y <= most(cell / cells_px_); ++y)
        for (int x = least(cell % cells_px_); x <= most(cell % cells_px_); ++x)
        {
            const std::uint32_t near = point_in_[static_cast<std::size_t>(y * cells_px_ + x)];
            if (near != nobody && points_[near].chart == chart)
                painted_[near] = 1;
        }
}

std::vector<std::uint32_t> Coverage::unpainted() const
{
    Numbers numbers;
    for (std::size_t i = 0; i < painted_.size(); ++i)
        if (painted_[i] == 0)
            numbers.push_back(static_cast<std::uint32_t>(i));
    return numbers;
}

double add_frames(Coverage& coverage, const Frames& frames, Progress& progress)
{
    std::vector<double> distances;
    std::size_t done = 0;
    for (const Frame& frame : frames.frames)
    {
        for (const std::uint32_t point : coverage.add(frame.color, load_mask(frame), progress))
            distances.push_back(
                length(vec_cast<double>(coverage.points()[point].position) - frame.color.world_from_camera.translation));
        progress.progress(static_cast<double>(++done), static_cast<double>(frames.frames.size()), "frames");
    }
    return distances.empty() ? 0 : numerics::median(std::move(distances));
}

std::vector<std::uint32_t> witnesses(const raycast::Scene& scene, std::span<const SurfacePoint> points,
                                     std::span<const Vec3d> places, std::span<const std::uint32_t> asked,
                                     const Progress& progress)
{
    // Far apart one after the other, so that the first few see nearly everything.
    std::size_t step = std::max<std::size_t>(1, places.size() * 5 / 8);
    while (std::gcd(step, places.size()) > 1)
        ++step;
    Numbers witness(points.size(), nobody);
    in_blocks(asked.size(), progress,
              [&](std::size_t begin, std::size_t end)
              {
                  const auto part = asked.subspan(begin, end - begin);
                  Numbers open(part.begin(), part.end());
                  for (std::size_t i = 0; i < places.size() && !open.empty(); ++i)
                  {
                      if (i % 64 == 0)
                          progress.check_canceled();
                      const std::size_t place = i * step % places.size();
                      const Numbers seen = visible_points(scene, points, places[place], open);
                      for (const std::uint32_t point : seen)
                          witness[point] = static_cast<std::uint32_t>(place);
                      Numbers left;
                      std::ranges::set_difference(open, seen, std::back_inserter(left));
                      open = std::move(left);
                  }
              });
    return witness;
}

namespace
{

using numerics::SeenCell;

/// Limits of one round: this many points, seen from as many places as the rays allow.
constexpr std::size_t most_points = 16'384;
constexpr std::size_t most_rays = 4'000'000;
constexpr std::size_t least_places = 64;
/// A round keeps the cameras that paint so much of what it looks at: the next one knows better what the rest needs.
constexpr double share_of_a_round = 0.8;
/// So few points are left to no other round.
constexpr std::size_t few_points = 256;

/// Some of `all`, evenly spread.
Numbers some_of(const Numbers& all, std::size_t most)
{
    if (all.size() <= most)
        return all;
    Numbers result;
    for (const std::size_t i : numerics::evenly_spread(most, all.size()))
        result.push_back(all[i]);
    return result;
}

void sort_unique(Numbers& numbers)
{
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// So many that every ray has one within about half the smaller angle of view.
std::size_t direction_count(const Intrinsics& intrinsics)
{
    const double half =
        std::min(std::atan(intrinsics.width / (2 * intrinsics.fx)), std::atan(intrinsics.height / (2 * intrinsics.fy)));
    return static_cast<std::size_t>(std::clamp(4 * std::numbers::pi / (half * half), 32.0, 1024.0));
}

/// No picture shows more than this cosine away from where its camera looks.
double least_cosine(const Intrinsics& intrinsics)
{
    double least = 1;
    for (const int x : {0, intrinsics.width})
        for (const int y : {0, intrinsics.height})
            least = std::min(least, 1 / length(Camera{intrinsics, {}}.ray(x, y)));
    return least;
}

class Planner
{
  public:
    Planner(Coverage& coverage, std::span<const Vec3d> places, const Numbers& witness_of, const PlanRules& rules,
            Progress& progress)
        : coverage_(coverage), points_(coverage.points()), places_(places), rules_(rules), progress_(progress),
          looks_(numerics::spread_directions(direction_count(rules.intrinsics))), least_cosine_(least_cosine(rules.intrinsics)),
          witness_of_(witness_of)
    {
    }

    ViewPlan operator()(Numbers wanted)
    {
        const auto all = static_cast<double>(wanted.size());
        ViewPlan plan{{}, std::move(wanted)};
        const auto done = [&]
        { return plan.unpainted.size() <= rules_.most_unpainted || plan.cameras.size() == rules_.most_views; };
        const auto take = [&](const Camera& camera)
        {
            if (done() || coverage_.add(camera, {}, progress_).empty())
                return;
            plan.cameras.push_back(camera);
            std::erase_if(plan.unpainted, [&](std::uint32_t point) { return coverage_.painted(point); });
            progress_.progress(all - static_cast<double>(plan.unpainted.size()), all, "cells");
        };
        while (!done())
        {
            const std::size_t before = plan.cameras.size();
            for (const Camera& camera : round(some_of(plan.unpainted, most_points)))
                take(camera);
            if (plan.cameras.size() == before)  // The remaining points lie between the directions: the angle of view is small.
                take(aimed_at(plan.unpainted.front()));
            if (plan.cameras.size() == before)  // Nor does the principal point lie in the picture.
                break;
        }
        return plan;
    }

  private:
    /// Cameras that see most of the points.
    std::vector<Camera> round(const Numbers& looked_at) const
    {
        const Numbers stands = stands_for(looked_at);
        std::vector<std::vector<SeenCell>> views(stands.size() * looks_.size());
        parallel_items(stands.size(), 1, progress_,
                       [&](std::size_t i) { look_around(places_[stands[i]], looked_at, &views[i * looks_.size()]); });
        const auto order = numerics::greedy_order(views, looked_at.size(), progress_);
        const double share = looked_at.size() <= few_points ? 1 : share_of_a_round;
        const std::size_t picks = numerics::picks_needed(order, share, order.size());
        std::vector<Camera> cameras;
        for (std::size_t i = 0; i < picks; ++i)
            cameras.push_back(camera_at(places_[stands[order[i].frame / looks_.size()]], order[i].frame % looks_.size()));
        return cameras;
    }

    /// Half of them witnesses of the points, half of them any.
    Numbers stands_for(const Numbers& looked_at) const
    {
        const std::size_t most = std::max(least_places, most_rays / looked_at.size());
        Numbers seeing;
        std::ranges::transform(looked_at, std::back_inserter(seeing), [&](std::uint32_t point) { return witness_of_[point]; });
        sort_unique(seeing);
        Numbers any(places_.size());
        std::iota(any.begin(), any.end(), 0U);
        Numbers stands = some_of(seeing, most / 2);
        const Numbers more = some_of(any, most / 2);
        stands.insert(stands.end(), more.begin(), more.end());
        sort_unique(stands);
        return stands;
    }

    Camera camera_at(Vec3d eye, std::size_t look) const
    {
        return level_camera(rules_.intrinsics, eye, looks_[look], rules_.upright);
    }

    Camera aimed_at(std::uint32_t point) const
    {
        const Vec3d eye = places_[witness_of_[point]];
        return level_camera(rules_.intrinsics, eye, normalized(vec_cast<double>(points_[point].position) - eye), rules_.upright);
    }

    /// Cells that each direction shows from one place; cells are numbers into `looked_at`.
    void look_around(Vec3d eye, const Numbers& looked_at, std::vector<SeenCell>* views) const
    {
        std::vector<Camera> cameras;
        for (std::size_t i = 0; i < looks_.size(); ++i)
            cameras.push_back(camera_at(eye, i));
        // Both ascend.
        std::uint32_t cell = 0;
        for (const std::uint32_t point : visible_points(coverage_.scene(), points_, eye, looked_at))
        {
            while (looked_at[cell] != point)
                ++cell;
            const std::uint32_t worth = worth_of(points_[point], eye);
            const Vec3d toward = normalized(vec_cast<double>(points_[point].position) - eye);
            for (std::size_t i = 0; i < looks_.size(); ++i)
                if (dot(looks_[i], toward) >= least_cosine_ && in_picture(cameras[i], {}, points_[point].position))
                    views[i].emplace_back(cell, worth);
        }
    }

    /// 1 … SeenCell::best_worth
    std::uint32_t worth_of(const SurfacePoint& point, Vec3d eye) const
    {
        const Vec3d toward = eye - vec_cast<double>(point.position);
        const double distance = length(toward);
        const double cosine = dot(vec_cast<double>(point.normal), toward) / distance;
        const double nearness = std::min(distance / rules_.distance_m, rules_.distance_m / distance);
        // Seeing it at all, straight on, and from the recorded frames' distance count alike.
        const double worth = (1 + cosine + nearness) / 3;
        return static_cast<std::uint32_t>(std::lround(1 + worth * (SeenCell::best_worth - 1)));
    }

    Coverage& coverage_;
    std::span<const SurfacePoint> points_;
    std::span<const Vec3d> places_;
    const PlanRules& rules_;
    Progress& progress_;
    std::vector<Vec3d> looks_;
    double least_cosine_;
    const Numbers& witness_of_;  ///< Per point.
};

}  // namespace

Upright upright_of(const Frames& frames, Vec3d up)
{
    double along_x = 0;
    double along_y = 0;
    for (const Frame& frame : frames.frames)
    {
        const Vec3d in_camera = transposed(frame.color.world_from_camera.rotation) * up;
        along_x += in_camera.x;
        along_y += in_camera.y;
    }
    if (std::abs(along_y) >= std::abs(along_x))
        return {up, along_y <= 0 ? 0 : 2};
    return {up, along_x <= 0 ? 1 : 3};
}

Camera level_camera(const Intrinsics& intrinsics, Vec3d eye, Vec3d forward, const Upright& upright)
{
    Vec3d right = cross(forward, upright.up);
    if (length(right) < 1e-6)
        right = cross(forward, std::abs(forward.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0});
    right = normalized(right);
    Vec3d down = cross(forward, right);
    for (int turn = 0; turn < upright.quarter_turns; ++turn)
        right = std::exchange(down, -right);
    Camera camera{intrinsics, {}};
    camera.world_from_camera = {{{right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z}}, eye};
    return camera;
}

ViewPlan plan_views(Coverage& coverage, std::span<const Vec3d> places, std::vector<std::uint32_t> wanted,
                    const std::vector<std::uint32_t>& witness_of, const PlanRules& rules, Progress& progress)
{
    return Planner(coverage, places, witness_of, rules, progress)(std::move(wanted));
}

namespace
{

constexpr const char* virtual_sequence = "virtual";

std::string percent(double share)
{
    return fmt::format("{:.2f} %", std::floor(share * 10'000) / 100);
}

}  // namespace

Frames with_virtual_frames(const Mesh& mesh, const Frames& recorded, const VirtualFrames& settings, RunContext& run)
{
    check_uv_mapping_inputs(mesh, recorded);
    std::vector<Vec3d> eyes;
    for (const Frame& frame : recorded.frames)
    {
        if (frame.sequence == virtual_sequence)
            throw Error(fmt::format("port 'frames' already has a virtual frame ({}/{}): wire the recorded frames", frame.sequence,
                                    frame.name));
        eyes.push_back(frame.color.world_from_camera.translation);
    }
    const VoxelGrid grid(mesh, eyes, {.voxel_m = settings.voxel_m, .clearance_m = settings.clearance_m});
    const raycast::Scene scene(mesh);
    const auto places = free_space(scene, grid, eyes, settings.clearance_m, run);
    if (places.empty())
        throw Error(fmt::format(
            "no free space: a virtual camera stands at the center of a voxel of {:g} m, {:g} m from all surfaces, with a free "
            "way to one of the {} recorded cameras, and there is no such place: check with scan.inspect that mesh and poses "
            "share one world frame",
            settings.voxel_m, settings.clearance_m, eyes.size()));
    const auto points = surface_points(mesh, settings.cells_px, run);
    Coverage coverage(scene, points, settings.cells_px,
                      mesh.texture_px > 0 ? settings.gap_px * settings.cells_px / mesh.texture_px : 0);
    const double distance_m = add_frames(coverage, recorded, run);
    if (distance_m == 0)
        throw Error(fmt::format("none of the {} frames sees the front of the mesh: check with scan.inspect that mesh and poses "
                                "share one world frame and that faces are counter-clockwise from outside",
                                eyes.size()));
    auto wanted = coverage.unpainted();
    const std::size_t painted = points.size() - wanted.size();
    const auto witness_of = witnesses(scene, points, places, wanted, run);
    std::erase_if(wanted, [&](std::uint32_t point) { return witness_of[point] == nobody; });
    std::vector<RigidTransform> poses;
    for (const Frame& frame : recorded.frames)
        poses.push_back(frame.color.world_from_camera);
    const geometry::Upward up = geometry::find_up(mesh, cameras_up(poses));
    if (up.from == geometry::UpEvidence::nothing)
        run.warning("neither the cameras nor the mesh clearly shows which way is up, so the file's axis is used: virtual "
                    "pictures may be tilted");
    const PlanRules rules{.intrinsics = recorded.frames.front().color.intrinsics,
                          .upright = upright_of(recorded, up.direction),
                          .distance_m = distance_m,
                          .most_unpainted =
                              static_cast<std::size_t>((1 - settings.target_coverage) * static_cast<double>(wanted.size())),
                          .most_views = settings.max_frames == 0 ? std::numeric_limits<std::size_t>::max()
                                                                 : static_cast<std::size_t>(settings.max_frames)};
    const auto plan = plan_views(coverage, places, wanted, witness_of, rules, run);

    Frames all = recorded;
    for (const Camera& camera : plan.cameras)
    {
        const std::size_t number = all.frames.size() - recorded.frames.size();
        Frame& frame = all.frames.emplace_back();
        frame.sequence = virtual_sequence;
        frame.name = fmt::format("view-{:06}", number);
        frame.number = static_cast<long>(number);
        frame.color = frame.depth = camera;
    }
    const auto reached = static_cast<double>(painted + wanted.size());
    const double recorded_share = static_cast<double>(painted) / reached;
    const double all_share = (reached - static_cast<double>(plan.unpainted.size())) / reached;
    run.report("recorded_frames", recorded.frames.size());
    run.report("virtual_frames", plan.cameras.size());
    run.report("free_voxels", places.size());
    run.report("cells", points.size());
    run.report("reachable_share", reached / static_cast<double>(points.size()));
    run.report("coverage_recorded", recorded_share);
    run.report("coverage", all_share);
    run.message(fmt::format("{} recorded frames paint {} of the surface that free space reaches; with {} virtual ones {}",
                            recorded.frames.size(), percent(recorded_share), plan.cameras.size(), percent(all_share)));
    return all;
}

}  // namespace fresco::virtual_views
