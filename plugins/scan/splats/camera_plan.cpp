#include "camera_plan.h"

#include <fresco/error.h>
#include <fresco/numerics/greedy_cover.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace scan_splats
{
namespace
{

using namespace fresco;
using splats::Splats;

/// About so many voxels, and at most so many along an axis.
constexpr double voxels_count = 1e6;
constexpr double most_along = 320;
/// A voxel blocks the view if Gaussians cover so much of its side.
constexpr double blocking = 0.4;
/// The part of a Gaussian that is entered, in standard deviations, and into how many pieces along an axis at most.
constexpr double entered = 1.5;
constexpr int most_pieces = 64;

/// Share of the directions that end in the scene from enclosed places: a room may lack its ceiling or two walls.
constexpr double enclosed_share = 0.65;
/// Enclosed places are preferred if they see nearly as much as those around, which see the backs of walls.
constexpr double nearly = 0.97;
constexpr int clearance_voxels = 3;
/// Relative to the largest one.
constexpr double small_hollow = 0.1;
constexpr std::size_t most_squares = 300'000;
constexpr std::size_t most_tried = 4000;
constexpr std::size_t most_inside = 100;
constexpr std::size_t places_around = 120;

const Intrinsics lens{640, 480, 480, 480, 320, 240};
/// Rays of a camera that is tried.
constexpr int rays_across = 48, rays_down = 36;
/// So many cameras see most of the surface.
constexpr int rounds = 2;
constexpr std::size_t most_cameras = 100;
/// Cameras look at an object from so far below: what it stands on has no underside.
constexpr double lowest_sine = -0.1;

/// The axes of a Gaussian, longest first, with their standard deviations as lengths.
std::array<Vec3d, 3> longest_axes(const Splats& splats, std::size_t i)
{
    auto axes = splats::axes_of(splats, i);
    const Vec3f scale = splats.scales[i];
    axes = {axes[0] * double{scale.x}, axes[1] * double{scale.y}, axes[2] * double{scale.z}};
    std::ranges::sort(axes, [](Vec3d a, Vec3d b) { return dot(a, a) > dot(b, b); });
    return axes;
}

/// Distance of the outer places around an object: all of it is in the picture.
double distance_around(const OpacityGrid& grid)
{
    return grid.radius_m() / std::sin(std::atan(lens.cy / lens.fy));
}

std::uint64_t gaussians_seen(const OpacityGrid& grid, std::span<const Vec3d> places, std::span<const Vec3d> looks,
                             const Progress& progress)
{
    std::vector<std::uint8_t> seen(grid.cells_count());
    std::vector<std::vector<std::uint32_t>> of_place(places.size());
    parallel_items(places.size(), 1, progress,
                   [&](std::size_t i)
                   {
                       for (const Vec3d look : looks)
                           if (const auto voxel = grid.cast(places[i], look, 0); voxel != OpacityGrid::none)
                               of_place[i].push_back(grid.cell_of(voxel));
                   });
    std::uint64_t sum = 0;
    for (const auto& cells : of_place)
        for (const std::uint32_t cell : cells)
            if (std::exchange(seen[cell], std::uint8_t{1}) == 0)
                sum += grid.gaussians(cell);
    return sum;
}

/// Clear places from which most directions end in the scene, but for those in small hollows, such as cupboards.
std::vector<Vec3d> enclosed(const OpacityGrid& grid, const Progress& progress)
{
    std::vector<std::uint8_t> is_clear(grid.count());
    parallel_items(is_clear.size(), 4096, progress,
                   [&](std::size_t voxel) { is_clear[voxel] = grid.clear(voxel, clearance_voxels) ? 1 : 0; });
    numerics::DisjointSets hollows(grid.count());
    std::vector<std::size_t> clear;
    for (std::size_t voxel = 0; voxel < grid.count(); ++voxel)
    {
        if (is_clear[voxel] == 0)
            continue;
        clear.push_back(voxel);
        for (const Vec3d step : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
            if (const auto next = grid.voxel_at(grid.center(voxel) + step * grid.voxel_m());
                next != OpacityGrid::none && is_clear[next] != 0)
                hollows.join(static_cast<std::uint32_t>(voxel), static_cast<std::uint32_t>(next));
    }
    const auto tried = numerics::evenly_spread(std::min(most_tried, clear.size()), clear.size());
    const auto looks = numerics::spread_directions(128);
    std::vector<std::uint8_t> is_enclosed(tried.size());
    parallel_items(tried.size(), 16, progress,
                   [&](std::size_t i)
                   {
                       const Vec3d at = grid.center(clear[tried[i]]);
                       const auto ends =
                           std::ranges::count_if(looks, [&](Vec3d look) { return grid.cast(at, look, 0) != OpacityGrid::none; });
                       is_enclosed[i] = static_cast<double>(ends) >= enclosed_share * static_cast<double>(looks.size());
                   });
    const auto hollow_of = [&](std::size_t i) { return hollows.find(static_cast<std::uint32_t>(clear[tried[i]])); };
    std::map<std::uint32_t, std::size_t> sizes;
    std::size_t largest = 0;
    for (std::size_t i = 0; i < tried.size(); ++i)
        if (is_enclosed[i] != 0)
            largest = std::max(largest, ++sizes[hollow_of(i)]);
    std::vector<Vec3d> found;
    for (std::size_t i = 0; i < tried.size(); ++i)
        if (is_enclosed[i] != 0 && static_cast<double>(sizes[hollow_of(i)]) >= small_hollow * static_cast<double>(largest))
            found.push_back(grid.center(clear[tried[i]]));
    return found;
}

Camera level_camera(Vec3d eye, Vec3d forward, Vec3d up)
{
    Vec3d right = cross(forward, up);
    if (length(right) < 1e-6)
        right = cross(forward, std::abs(forward.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0});
    right = normalized(right);
    const Vec3d down = cross(forward, right);
    return {lens, {{{right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z}}, eye}};
}

/// Every camera that is tried.
std::vector<Camera> candidates(const OpacityGrid& grid, const Places& places, Vec3d up)
{
    std::vector<Camera> cameras;
    const auto looks = numerics::spread_directions(32);
    for (const Vec3d place : places.places)
    {
        const Vec3d inward = normalized(grid.middle() - place);
        if (places.inside)
            for (const Vec3d look : looks)
                cameras.push_back(level_camera(place, look, up));
        else if (dot(inward, up) < -lowest_sine)
            for (const Vec3d look : looks)
                if (dot(look, inward) > 0.88)
                    cameras.push_back(level_camera(place, look, up));
    }
    return cameras;
}

}  // namespace

OpacityGrid::OpacityGrid(const Splats& splats)
{
    numerics::Bounds<double> box;
    for (const Vec3f center : splats.centers)
        box.add(vec_cast<double>(center));
    const Vec3d size = box.high - box.low;
    const double longest = std::max({size.x, size.y, size.z});
    if (!(longest > 0) || !std::isfinite(longest))
        throw Error("all Gaussians lie at one point: there is no surface");
    const double thinnest = longest / most_along;
    const double volume = std::max(size.x, thinnest) * std::max(size.y, thinnest) * std::max(size.z, thinnest);
    voxel_m_ = std::max(std::cbrt(volume / voxels_count), thinnest);
    const auto along = [&](double side) { return static_cast<int>(std::ceil(side / voxel_m_)) + 2; };
    counts_ = {along(size.x), along(size.y), along(size.z)};
    low_ = (box.low + box.high) * 0.5 - Vec3d{counts_[0] * 0.5, counts_[1] * 0.5, counts_[2] * 0.5} * voxel_m_;
    const auto all =
        static_cast<std::size_t>(counts_[0]) * static_cast<std::size_t>(counts_[1]) * static_cast<std::size_t>(counts_[2]);
    std::vector<double> covered(all);
    gaussians_.resize(cell_of(all - 1) + 1);
    blocked_.resize(all);
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        const Vec3d center = vec_cast<double>(splats.centers[i]);
        ++gaussians_[cell_of(voxel_at(center))];
        const auto axes = longest_axes(splats, i);
        const auto pieces = [&](Vec3d axis)
        { return static_cast<int>(std::min(std::ceil(2 * entered * length(axis) / voxel_m_), most_pieces - 1.0)) + 1; };
        const int across = pieces(axes[0]), down = pieces(axes[1]);
        const double each = static_cast<double>(splats.opacities[i]) * 2 * std::numbers::pi * length(axes[0]) * length(axes[1]) /
                            (across * down * voxel_m_ * voxel_m_);
        for (int a = 0; a < across; ++a)
            for (int b = 0; b < down; ++b)
            {
                const auto at = [&](int piece, int of) { return entered * ((2 * piece + 1.0) / of - 1); };
                if (const auto voxel = voxel_at(center + axes[0] * at(a, across) + axes[1] * at(b, down)); voxel != none)
                    covered[voxel] += each;
            }
    }
    numerics::Bounds<double> seen;
    for (std::size_t voxel = 0; voxel < all; ++voxel)
        if (covered[voxel] >= blocking)
        {
            blocked_[voxel] = 1;
            seen.add(this->center(voxel));
        }
    middle_ = (seen.low + seen.high) * 0.5;
    for (std::size_t voxel = 0; voxel < all; ++voxel)
        if (blocked_[voxel] != 0)
            radius_m_ = std::max(radius_m_, length(this->center(voxel) - middle_));
    if (!(radius_m_ > 0))
        throw Error("the Gaussians are too faint or too few to make a surface");
}

Vec3d OpacityGrid::center(std::size_t voxel) const
{
    const auto v = static_cast<int>(voxel);
    const int x = v % counts_[0], y = v / counts_[0] % counts_[1], z = v / (counts_[0] * counts_[1]);
    return low_ + Vec3d{x + 0.5, y + 0.5, z + 0.5} * voxel_m_;
}

std::size_t OpacityGrid::voxel_at(Vec3d point) const
{
    const Vec3d at = (point - low_) * (1 / voxel_m_);
    if (!(at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < counts_[0] && at.y < counts_[1] && at.z < counts_[2]))
        return none;
    return static_cast<std::size_t>((static_cast<int>(at.z) * counts_[1] + static_cast<int>(at.y)) * counts_[0] +
                                    static_cast<int>(at.x));
}

std::uint32_t OpacityGrid::cell_of(std::size_t voxel) const
{
    const auto v = static_cast<int>(voxel);
    const int x = v % counts_[0], y = v / counts_[0] % counts_[1], z = v / (counts_[0] * counts_[1]);
    return static_cast<std::uint32_t>((z / 3 * (counts_[1] / 3 + 1) + y / 3) * (counts_[0] / 3 + 1) + x / 3);
}

bool OpacityGrid::clear(std::size_t voxel, int voxels) const
{
    const Vec3d middle = center(voxel);
    for (int z = -voxels; z <= voxels; ++z)
        for (int y = -voxels; y <= voxels; ++y)
            for (int x = -voxels; x <= voxels; ++x)
                if (const auto near = voxel_at(middle + Vec3d{x * voxel_m_, y * voxel_m_, z * voxel_m_});
                    near != none && blocked(near))
                    return false;
    return true;
}

std::size_t OpacityGrid::cast(Vec3d origin, Vec3d direction, double from_m) const
{
    // No voxel is farther from the box's middle than half its diagonal.
    const Vec3d half = Vec3d{counts_[0] * 0.5, counts_[1] * 0.5, counts_[2] * 0.5} * voxel_m_;
    const double beside = dot(low_ + half - origin, direction), reach = length(half);
    const double begin = std::max(from_m, beside - reach), end = beside + reach;
    const double step = voxel_m_ / 2;
    for (double at = begin + step / 2; at < end; at += step)
        if (const auto voxel = voxel_at(origin + direction * at); voxel != none && blocked(voxel))
            return voxel;
    return none;
}

Places find_places(const OpacityGrid& grid, Stand stand, const Progress& progress)
{
    const auto all = numerics::spread_directions(places_around);
    std::vector<Vec3d> around;
    for (const double distance : {1.0, 0.75})
        for (const Vec3d direction : all)
            if (const Vec3d at = grid.middle() + direction * (distance * distance_around(grid)); true)
            {
                const auto voxel = grid.voxel_at(at);
                if (voxel == OpacityGrid::none || grid.clear(voxel, clearance_voxels))
                    around.push_back(at);
            }
    auto inside = enclosed(grid, progress);
    if (stand == Stand::inside && inside.empty())
        throw Error("stand: inside, but the scene encloses no free space: set stand: around");
    std::vector<Vec3d> some;
    for (const std::size_t i : numerics::evenly_spread(std::min(most_inside, inside.size()), inside.size()))
        some.push_back(inside[i]);
    std::uint64_t gaussians = 0;
    for (std::size_t cell = 0; cell < grid.cells_count(); ++cell)
        gaussians += grid.gaussians(cell);
    const auto looks = numerics::spread_directions(4000);
    const auto share = [&](const std::vector<Vec3d>& places)
    { return static_cast<double>(gaussians_seen(grid, places, looks, progress)) / static_cast<double>(gaussians); };
    Places found{false, {}, share(some), share(around)};
    found.inside = stand == Stand::inside || (stand == Stand::automatic && found.inside_share >= nearly * found.around_share);
    found.places = found.inside ? some : around;
    return found;
}

Mesh facing_squares(const Splats& splats, const OpacityGrid& grid, bool inside, const Progress& progress)
{
    Mesh mesh;
    const std::size_t step = 1 + splats.size() / most_squares, count = (splats.size() + step - 1) / step;
    mesh.positions.resize(4 * count);
    mesh.triangles.resize(2 * count);
    const double skipped = 2 * grid.voxel_m();
    parallel_items(count, 1024, progress,
                   [&](std::size_t i)
                   {
                       const Vec3d center = vec_cast<double>(splats.centers[i * step]);
                       const auto axes = longest_axes(splats, i * step);
                       const Vec3d normal = normalized(cross(axes[0], axes[1]));
                       const auto free = [&](Vec3d front)
                       {
                           double sum = 0;
                           for (const Vec3d lean : {Vec3d{}, axes[0], -axes[0], axes[1], -axes[1]})
                           {
                               const auto end = grid.cast(center, normalized(front + normalized(lean)), skipped);
                               const double beyond = inside ? 0 : 2 * grid.radius_m();
                               sum += end == OpacityGrid::none ? beyond : length(grid.center(end) - center);
                           }
                           return sum;
                       };
                       const Vec3d side = axes[1] * (free(normal) < free(-normal) ? -1.0 : 1.0);
                       const auto first = static_cast<std::uint32_t>(4 * i);
                       const std::array corners{center - axes[0] - side, center + axes[0] - side, center + axes[0] + side,
                                                center - axes[0] + side};
                       for (std::size_t corner = 0; corner < 4; ++corner)
                           mesh.positions[first + corner] = vec_cast<float>(corners[corner]);
                       mesh.triangles[2 * i] = {first, first + 1, first + 2};
                       mesh.triangles[2 * i + 1] = {first, first + 2, first + 3};
                   });
    return mesh;
}

CameraPlan plan_cameras(const OpacityGrid& grid, const Places& places, Vec3d up, const Progress& progress)
{
    CameraPlan plan;
    plan.nearest_m = places.inside ? grid.voxel_m() : 0.1 * distance_around(grid);
    const auto tried = candidates(grid, places, up);
    const std::size_t cells = grid.cells_count();
    std::vector<std::vector<numerics::SeenCell>> views(tried.size());
    parallel_items(tried.size(), 1, progress,
                   [&](std::size_t i)
                   {
                       std::vector<std::pair<std::uint32_t, std::uint32_t>> seen;
                       const Vec3d eye = tried[i].world_from_camera.translation;
                       for (int y = 0; y < rays_down; ++y)
                           for (int x = 0; x < rays_across; ++x)
                           {
                               const Vec3d ray = normalized(
                                   tried[i].ray((x + 0.5) * lens.width / rays_across, (y + 0.5) * lens.height / rays_down));
                               const auto voxel = grid.cast(eye, ray, plan.nearest_m);
                               if (voxel == OpacityGrid::none)
                                   continue;
                               const double near = distance_around(grid) / (4 * length(grid.center(voxel) - eye));
                               seen.emplace_back(grid.cell_of(voxel),
                                                 static_cast<std::uint32_t>(std::lround(127 + 128 * std::min(near, 1.0))));
                           }
                       std::ranges::sort(seen);
                       for (std::size_t s = 0; s < seen.size(); ++s)
                           if (s + 1 == seen.size() || seen[s + 1].first != seen[s].first)
                               views[i].emplace_back(seen[s].first, seen[s].second);
                   });
    std::vector<std::size_t> chosen;
    for (int round = 0; round < rounds; ++round)
    {
        const auto order = numerics::greedy_order(views, cells, progress);
        const auto picks =
            numerics::picks_needed(order, 0.98, (most_cameras - plan.cameras.size()) / static_cast<std::size_t>(rounds - round));
        for (std::size_t i = 0; i < picks; ++i)
        {
            plan.cameras.push_back(tried[order[i].frame]);
            chosen.push_back(order[i].frame);
            if (round == 0)
                plan.seen_share += static_cast<double>(order[i].new_cells);
        }
        if (round == 0)
        {
            std::vector<std::size_t> any(tried.size());
            std::iota(any.begin(), any.end(), std::size_t{0});
            const auto most = numerics::cells_seen(views, any, cells);
            plan.seen_share = most > 0 ? plan.seen_share / static_cast<double>(most) : 0;
        }
        for (const std::size_t frame : chosen)
            views[frame].clear();
    }
    return plan;
}

}  // namespace scan_splats
