#include <fresco/camera.h>
#include <fresco/error.h>
#include <fresco/geometry/topology.h>
#include <fresco/geometry/upright.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <numbers>
#include <vector>

namespace fresco::geometry
{

namespace
{

/// How far a face may lean to count as level: scans of floors are bumpy.
constexpr double level_deg = 8;
/// How far the cameras' direction may be off.
constexpr double cameras_deg = 30;
constexpr double plane_thickness_m = 0.08;
/// Less of the area is no evidence of a floor.
constexpr double least_level_share = 0.02;
/// How much more lies level at the one end than at the other to be the ground.
constexpr double clearly_more = 1.25;
/// Without cameras: what must stand or lie along a direction, of the area. It is 0.15 for a sphere.
constexpr double least_shape_share = 0.4;
/// Largest share of the evidence that the second-best direction may have.
constexpr double most_next_share = 0.9;
/// How much more must face up than down to tell which is which: scans lack ceilings and what buildings stand on.
constexpr double least_facing_share = 0.04;
/// Walls around a direction, of the area: a floor and a facade look alike.
constexpr double least_walls_share = 0.1;
/// Level planes at least this large, relative to the largest, are floors, ceilings or walls, not furniture.
constexpr double large_plane = 0.25;
/// Ends::inner_facing, of the area.
constexpr double least_inner_share = 0.02;
/// Largest inner_facing allowed along either direction across, relative to the upright one. Of 1564 generated models, these three
/// limits lay none on its side and stand 455 upright; without them 315 lay wrong and 841 stood.
constexpr double most_inner_across = 0.75;

using numerics::cosine_deg;

/// Directions all over half a sphere, 3 degrees apart.
std::vector<Vec3d> half_sphere()
{
    constexpr std::size_t count = 2000;
    auto directions = numerics::spread_directions(2 * count);
    directions.resize(count);
    return directions;
}

/// The area that faces along nearly the same direction, and the sum of its area vectors.
struct Facing
{
    Vec3d sum;
    Vec3d normal;
    double area = 0;
};

struct FacingAreas
{
    std::vector<Facing> bins;
    double area = 0;  ///< Area of the mesh.

    explicit FacingAreas(const Mesh& mesh)
    {
        constexpr int half = 40;
        constexpr auto side = static_cast<std::size_t>(2 * half + 1);
        constexpr std::uint32_t unused = 0xffffffffU;
        std::vector<std::uint32_t> bin_of(side * side * side, unused);
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        {
            const Vec3d vector = area_vector(mesh, f) * 0.5;
            const double face_area = length(vector);
            if (!(face_area > 0))
                continue;
            const auto cell = [&](double part) { return static_cast<std::size_t>(std::lround(half * part / face_area) + half); };
            std::uint32_t& bin = bin_of[(cell(vector.z) * side + cell(vector.y)) * side + cell(vector.x)];
            if (bin == unused)
            {
                bin = static_cast<std::uint32_t>(bins.size());
                bins.emplace_back();
            }
            bins[bin].sum += vector;
            bins[bin].area += face_area;
            area += face_area;
        }
        for (Facing& bin : bins)
            bin.normal = normalized(bin.sum);
    }

    /// Area that faces along the axis, to either side.
    double along(Vec3d axis) const
    {
        double sum = 0;
        for (const Facing& bin : bins)
            if (std::abs(dot(bin.normal, axis)) > cosine_deg(level_deg))
                sum += bin.area;
        return sum;
    }

    /// The mean of what faces along about this axis, narrowed down.
    Vec3d refined(Vec3d axis) const
    {
        for (const double degrees : {8.0, 6.0, 4.0, 4.0})
        {
            Vec3d sum;
            for (const Facing& bin : bins)
                if (const double cosine = dot(bin.normal, axis); std::abs(cosine) > cosine_deg(degrees))
                    sum += bin.sum * (cosine > 0 ? 1.0 : -1.0);
            if (length(sum) > 0)
                axis = normalized(sum);
        }
        return axis;
    }

    /// Evidence that an axis is the upright one.
    struct Evidence
    {
        double walls = 0;   ///< Around it, less what faces to one side only; of the area.
        double shape = 0;   ///< The walls and level surfaces.
        double facing = 0;  ///< How much more faces its positive side than the other, of the area.
        double all = 0;     ///< To compare axes by: the shape, the larger side of what is level, and how unlike both sides are.
    };

    /// A box stands along three axes, a roof's ridge is one of them; but only along the upright one both sides are unlike.
    Evidence evidence(Vec3d axis) const
    {
        constexpr std::size_t steps = 64;
        std::array<double, steps> unlike{};
        double front = 0, back = 0, walls = 0;
        Vec3d walls_sum;
        Evidence found;
        for (const Facing& bin : bins)
        {
            const double cosine = dot(bin.normal, axis);
            found.facing += bin.area * cosine / area;
            if (std::abs(cosine) > cosine_deg(level_deg))
                (cosine > 0 ? front : back) += bin.area;
            else if (std::abs(cosine) < cosine_deg(90 - level_deg))
            {
                walls += bin.area;
                walls_sum += bin.sum;
            }
            const auto step = std::min(static_cast<std::size_t>(std::abs(cosine) * steps), steps - 1);
            unlike[step] += cosine > 0 ? bin.area : -bin.area;
        }
        // The area times the cosine that would have to move to make both sides alike.
        double moved = 0;
        double beyond = 0;
        for (std::size_t step = steps; step-- > 0;)
        {
            beyond += unlike[step];
            moved += std::abs(beyond) / steps;
        }
        found.walls = std::max(walls - length(walls_sum), 0.0) / area;
        found.shape = found.walls + (front + back) / area;
        found.all = found.shape + (std::max(front, back) + 5 * moved) / area;
        return found;
    }

    /// The axis nearby that walls are square to and that level surfaces face along, by least squares.
    Vec3d squared(Vec3d axis) const
    {
        for (const double degrees : {8.0, 6.0, 4.0, 4.0})
        {
            const Vec3d near = axis;
            for (int round = 0; round < 100; ++round)
            {
                // One step to the eigenvector of the least eigenvalue.
                Vec3d next;
                for (const Facing& bin : bins)
                {
                    const double cosine = std::abs(dot(bin.normal, near));
                    const bool is_level = cosine > cosine_deg(degrees);
                    if (is_level || cosine < cosine_deg(90 - degrees))
                        next += (axis - bin.normal * (is_level ? -1.0 : 1.0) * dot(bin.normal, axis)) * bin.area;
                }
                if (!(length(next) > 0))
                    return axis;
                axis = normalized(next);
            }
        }
        return axis;
    }
};

/// Area of the mesh's largest plane that faces along `up`.
double largest_plane(const Mesh& mesh, Vec3d up)
{
    struct Level
    {
        double height;
        double area;
    };
    std::vector<Level> levels;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const Vec3d vector = area_vector(mesh, f) * 0.5;
        const double area = length(vector);
        if (!(area > 0) || !(dot(vector, up) > area * cosine_deg(level_deg)))
            continue;
        const auto& [a, b, c] = mesh.triangles[f];
        const Vec3f sum = mesh.positions[a] + mesh.positions[b] + mesh.positions[c];
        levels.push_back({dot(vec_cast<double>(sum), up) / 3, area});
    }
    std::ranges::sort(levels, [](const Level& a, const Level& b)
                      { return a.height != b.height ? a.height < b.height : a.area < b.area; });
    double most = 0;
    double sum = 0;
    std::size_t begin = 0;
    for (const Level& level : levels)
    {
        sum += level.area;
        for (; levels[begin].height < level.height - plane_thickness_m; ++begin)
            sum -= levels[begin].area;
        most = std::max(most, sum);
    }
    return most;
}

/// The coordinate axis that `direction` is nearest to, with its sign.
Vec3d nearest_axis(Vec3d direction)
{
    const std::array of{direction.x, direction.y, direction.z};
    const auto size = [](double part) { return std::abs(part); };
    const auto main = static_cast<std::size_t>(std::ranges::max_element(of, {}, size) - of.begin());
    std::array<double, 3> axis{};
    axis[main] = of[main] < 0 ? -1 : 1;
    return {axis[0], axis[1], axis[2]};
}

/// Evidence about the two ends of a direction and the surfaces between them.
struct Ends
{
    int flatter = 0;  ///< 1: clearly more lies level at the bottom than at the top; -1: the other way round.
    /// How much more area faces the top than the bottom, without large planes: a room that lacks its ceiling and one that lacks a
    /// wall are the same box, but tables, seats and roofs face up in both.
    double inner_facing = 0;
};

Ends ends_along(const Mesh& mesh, Vec3d up)
{
    if (mesh.positions.empty())
        return {};
    std::vector<double> heights;
    for (const Vec3f p : mesh.positions)
        heights.push_back(dot(vec_cast<double>(p), up));
    // Loose fragments beyond a scanned room are not its end.
    std::vector<double> sorted = heights;
    const auto outer = static_cast<std::ptrdiff_t>(sorted.size() / 100);
    std::ranges::nth_element(sorted, sorted.begin() + outer);
    const double low = sorted[static_cast<std::size_t>(outer)];
    std::ranges::nth_element(sorted, sorted.end() - 1 - outer);
    const double high = *(sorted.end() - 1 - outer);
    // The level surfaces of either side, by place along the direction.
    constexpr std::size_t steps = 50;
    std::array<std::array<double, steps + 1>, 2> levels{};
    const auto level_of = [&](std::size_t face, Vec3d vector) -> double*
    {
        const double along = dot(vector, up);
        if (!(std::abs(along) > length(vector) * cosine_deg(level_deg)))
            return nullptr;
        const auto& [a, b, c] = mesh.triangles[face];
        const double place = ((heights[a] + heights[b] + heights[c]) / 3 - low) / std::max(high - low, 1e-9);
        return &levels[along > 0 ? 1 : 0][static_cast<std::size_t>(std::clamp(place, 0.0, 1.0) * steps + 0.5)];
    };
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        if (const Vec3d vector = area_vector(mesh, f) * 0.5; double* level = level_of(f, vector))
            *level += length(vector);
    double largest = 0;
    for (const auto& side : levels)
        largest = std::max(largest, *std::ranges::max_element(side));
    Ends found;
    double bottom = 0, top = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const Vec3d vector = area_vector(mesh, f) * 0.5;
        const double* level = level_of(f, vector);
        if (level == nullptr || *level < large_plane * largest)
            found.inner_facing += dot(vector, up);
    }
    for (const auto& side : levels)
        for (std::size_t i = 0; i < steps / 10; ++i)
        {
            bottom += side[i];
            top += side[steps - i];
        }
    if (bottom > clearly_more * top)
        found.flatter = 1;
    else if (top > clearly_more * bottom)
        found.flatter = -1;
    return found;
}

Upward by_shape(const Mesh& mesh, const FacingAreas& areas)
{
    const std::vector<Vec3d> directions = half_sphere();
    std::vector<double> of;
    for (const Vec3d direction : directions)
        of.push_back(areas.evidence(direction).all);
    const Vec3d axis = areas.squared(directions[static_cast<std::size_t>(std::ranges::max_element(of) - of.begin())]);
    const FacingAreas::Evidence best = areas.evidence(axis);
    std::size_t next = directions.size();
    for (std::size_t i = 0; i < directions.size(); ++i)
        if (std::abs(dot(axis, directions[i])) < cosine_deg(cameras_deg) && (next == directions.size() || of[i] > of[next]))
            next = i;
    // Files have z or y up. Along x, rounding must not choose between them.
    const bool is_y = std::abs(axis.y) > std::max(std::abs(axis.z), 0.1);
    Upward result{is_y ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1}, UpEvidence::nothing};
    result.shape_share = best.shape;
    const Vec3d next_axis = areas.squared(directions[next]);
    result.next_share = std::min(1.0, areas.evidence(next_axis).all / best.all);
    if (best.shape < least_shape_share || result.next_share > most_next_share)
        return result;
    const Vec3d across = normalized(cross(axis, next_axis));
    const auto inner = [&](Vec3d direction) { return std::abs(ends_along(mesh, direction).inner_facing) / areas.area; };
    const Ends ends = ends_along(mesh, axis);
    const double side = std::abs(best.facing) > least_facing_share ? best.facing : ends.flatter;
    const double least = std::max(least_inner_share, std::max(inner(across), inner(cross(across, axis))) / most_inner_across);
    if (best.walls > least_walls_share && side * ends.inner_facing > least * std::abs(side) * areas.area)
    {
        result.direction = axis * (side > 0 ? 1.0 : -1.0);
        result.from = UpEvidence::shape;
    }
    return result;
}

}  // namespace

Upward find_up(const Mesh& mesh, const std::optional<Vec3d>& by_cameras)
{
    const FacingAreas areas(mesh);
    Upward result{by_cameras.value_or(Vec3d{0, 0, 1}), by_cameras ? UpEvidence::cameras : UpEvidence::nothing};
    if (!(areas.area > 0))
        return result;
    if (!by_cameras)
        result = by_shape(mesh, areas);
    else
    {
        const auto near_cameras = [&](Vec3d axis) { return std::abs(dot(axis, *by_cameras)) > cosine_deg(cameras_deg); };
        Vec3d axis = *by_cameras;
        double most = areas.along(axis);
        for (const Vec3d direction : half_sphere())
            if (near_cameras(direction))
                if (const double area = areas.along(direction); area > most)
                {
                    most = area;
                    axis = direction;
                }
        axis = areas.refined(axis);
        const double cosine = dot(axis, *by_cameras);
        if (near_cameras(axis) && areas.along(axis) > least_level_share * areas.area)
            result = {axis * (cosine < 0 ? -1.0 : 1.0), UpEvidence::cameras_and_plane,
                      std::acos(std::min(1.0, std::abs(cosine))) * 180 / std::numbers::pi};
    }
    result.plane_share = largest_plane(mesh, result.direction) / areas.area;
    return result;
}

namespace
{

using Quaternion = std::array<double, 4>;

Quaternion shortest_turn(Vec3d from, Vec3d to)
{
    const Vec3d axis = cross(from, to);
    const double w = 1 + dot(from, to);
    if (w < 1e-12)
        return {1, 0, 0, 0};
    const double scale = 1 / std::sqrt(dot(axis, axis) + w * w);
    return {axis.x * scale, axis.y * scale, axis.z * scale, w * scale};
}

/// First b, then a.
Quaternion product(const Quaternion& a, const Quaternion& b)
{
    const Vec3d u{a[0], a[1], a[2]};
    const Vec3d v{b[0], b[1], b[2]};
    const Vec3d w = v * a[3] + u * b[3] + cross(u, v);
    return {w.x, w.y, w.z, a[3] * b[3] - dot(u, v)};
}

}  // namespace

std::array<double, 4> upright_turn(Vec3d up, Vec3d target)
{
    const Quaternion coarse = shortest_turn(nearest_axis(up), target);
    return product(shortest_turn(turned(coarse, up), target), coarse);
}

Vec3d turned(const std::array<double, 4>& turn, Vec3d v)
{
    const Vec3d axis{turn[0], turn[1], turn[2]};
    const Vec3d once = cross(axis, v) * 2.0;
    return v + once * turn[3] + cross(axis, once);
}

namespace
{

constexpr std::array<double, 4> no_turn{0, 0, 0, 1};

/// By UpEvidence.
constexpr std::array evidence_names{"cameras and plane", "cameras", "shape", "nothing"};

std::string percent(double share)
{
    return fmt::format("{:.1f}%", 100 * share);
}

struct NamedAxis
{
    std::string_view name;
    Vec3d direction;
};

constexpr std::array<NamedAxis, 6> named_axes{
    {{"x", {1, 0, 0}}, {"y", {0, 1, 0}}, {"z", {0, 0, 1}}, {"-x", {-1, 0, 0}}, {"-y", {0, -1, 0}}, {"-z", {0, 0, -1}}}};

/// The axis that `direction` is nearest to.
std::string name_of(Vec3d direction)
{
    return std::string(
        std::ranges::max_element(named_axes, {}, [&](const NamedAxis& axis) { return dot(axis.direction, direction); })->name);
}

constexpr std::string_view not_shown = "the mesh does not clearly show which way is up";

std::string sentence(const Upward& up)
{
    const std::string floor = "the largest level plane is " + percent(up.plane_share) + " of the surface";
    switch (up.from)
    {
    case UpEvidence::cameras_and_plane:
        return fmt::format("up: from the cameras; the level surfaces agree within {:.1f} degrees; {}", up.plane_deg, floor);
    case UpEvidence::cameras:
        return "up: from the cameras; the mesh has no level plane near their direction";
    case UpEvidence::shape:
        return "up: " + name_of(up.direction) +
               ", from the mesh's walls, level surfaces and furniture, without cameras; the next best direction has " +
               percent(up.next_share) + " of the evidence; " + floor;
    case UpEvidence::nothing:
        break;
    }
    return std::string(not_shown) + ": its axes are kept; wire 'frames', whose cameras show it, or set up: x, y, z, -x, -y or -z";
}

/// Warns where the mesh by itself clearly stands another way than `up`, which `said` says.
void warn_of_other(const Mesh& mesh, Vec3d up, const std::string& said, RunContext& run)
{
    const Upward found = find_up(mesh, std::nullopt);
    if (found.from != UpEvidence::shape || dot(found.direction, up) > cosine_deg(45))
        return;
    const std::string other = name_of(found.direction);
    run.warning(said + ", but by its walls, level surfaces and furniture the mesh stands along " + other +
                " (the next best direction has " + percent(found.next_share) +
                " of the evidence); if it comes out lying or upside down, set up: " + other);
}

/// The axis that x, y, z, -x, -y or -z names. Warns where the mesh clearly stands another way.
Vec3d named_up(const std::string& name, const Mesh& mesh, RunContext& run)
{
    const Vec3d up = std::ranges::find(named_axes, name, &NamedAxis::name)->direction;
    warn_of_other(mesh, up, "up: " + name, run);
    return up;
}

Upward found_up(const Mesh& mesh, const Input<Frames>& frames, RunContext& run)
{
    std::vector<RigidTransform> poses;
    if (frames.has_value())
        for (const Frame& frame : frames->frames)
            poses.push_back(frame.color.world_from_camera);
    const Upward up = find_up(mesh, poses.empty() ? std::nullopt : cameras_up(poses));
    run.report("up_from", evidence_names[static_cast<std::size_t>(up.from)]);
    run.report("up_plane_share", up.plane_share);
    if (up.shape_share > 0)
    {
        run.report("up_shape_share", up.shape_share);
        run.report("up_next_share", up.next_share);
    }
    if (up.from == UpEvidence::cameras_and_plane)
        run.report("up_plane_deg", up.plane_deg);
    // Notice recorders that were held upside down.
    if ((up.from == UpEvidence::cameras_and_plane || up.from == UpEvidence::cameras) &&
        ends_along(mesh, up.direction).inner_facing < 0)
        warn_of_other(mesh, up.direction, "up: from the cameras, along " + name_of(up.direction), run);
    return up;
}

}  // namespace

Option<std::string> up_option(Configurable* owner)
{
    return {owner, "up", "auto", one_of({"auto", "x", "y", "z", "-x", "-y", "-z"}),
            "World axis that points up; auto: found from the frames' cameras and the mesh's walls and level surfaces"};
}

Vec3d shown_up(const std::string& name, const Mesh& mesh, const Input<Frames>& frames, RunContext& run)
{
    if (name != "auto")
        return named_up(name, mesh, run);
    const Upward up = found_up(mesh, frames, run);
    if (up.from == UpEvidence::nothing)
        run.warning(fmt::format("up: auto: {}, so {} is used; set up: x, y, z, -x, -y or -z, or wire 'frames', whose cameras "
                                "show it",
                                not_shown, name_of(up.direction)));
    return up.direction;
}

UprightOption::UprightOption(Configurable* owner)
    : frames_(owner, "frames", optional, "Frames whose cameras show which way is up"),
      up_(owner, "up", "auto", one_of({"auto", "keep", "x", "y", "z", "-x", "-y", "-z"}),
          "World axis that points up and is turned to the file format's; auto: found from the frames' cameras and the mesh's "
          "walls and level surfaces; keep: no rotation")
{
}

std::array<double, 4> UprightOption::turn(const Mesh& mesh, Vec3d target, RunContext& run) const
{
    if (*up_ == "keep")
        return no_turn;
    Vec3d up;
    if (*up_ == "auto")
    {
        const Upward found = found_up(mesh, frames_, run);
        run.message(sentence(found));
        if (found.from == UpEvidence::nothing)
            return no_turn;
        up = found.direction;
    }
    else
        up = named_up(*up_, mesh, run);
    run.report("up", Value::List{up.x, up.y, up.z});
    return upright_turn(up, target);
}

Mesh UprightOption::standing(const Mesh& mesh, Vec3d target, RunContext& run) const
{
    const std::array<double, 4> by = turn(mesh, target, run);
    Mesh result = mesh;
    if (by == no_turn)
        return result;
    result.offset_m = turned(by, mesh.offset_m);
    for (Vec3f& position : result.positions)
        position = vec_cast<float>(turned(by, vec_cast<double>(position)));
    return result;
}

}  // namespace fresco::geometry
