#include <fresco/camera.h>
#include <fresco/geometry/topology.h>
#include <fresco/geometry/upright.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <numbers>

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
/// How much more than the next best is sure.
constexpr double clearly_more = 1.25;

using numerics::cosine_deg;

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
    double area = 0;  ///< Of the mesh.

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

    /// That faces along the axis, to either side or only to its positive one.
    double along(Vec3d axis, bool either_side = true) const
    {
        double sum = 0;
        for (const Facing& bin : bins)
            if (const double cosine = dot(bin.normal, axis); (either_side ? std::abs(cosine) : cosine) > cosine_deg(level_deg))
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

    /// Of directions all over half a sphere, and of `direction`, the one that most area faces along among those that `allowed`
    /// accepts; refined. Nothing where it accepts none.
    template <class Allowed>
    std::optional<Vec3d> best(std::optional<Vec3d> direction, const Allowed& allowed) const
    {
        constexpr int count = 2000;
        constexpr double golden_angle = 2.399963;
        double most = direction ? along(*direction) : -1;
        for (int i = 0; i < count; ++i)
        {
            const double z = 1 - (i + 0.5) / count;
            const double radius = std::sqrt(1 - z * z);
            const Vec3d axis{radius * std::cos(golden_angle * i), radius * std::sin(golden_angle * i), z};
            if (!allowed(axis))
                continue;
            if (const double area_along = along(axis); area_along > most)
            {
                most = area_along;
                direction = axis;
            }
        }
        return direction ? std::optional(refined(*direction)) : std::nullopt;
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

std::array<double, 3> parts(Vec3d v)
{
    return {v.x, v.y, v.z};
}

/// The coordinate axis that `direction` is nearest to, with its sign.
Vec3d nearest_axis(Vec3d direction)
{
    const std::array<double, 3> of = parts(direction);
    const auto larger = [](double a, double b) { return std::abs(a) < std::abs(b); };
    const auto main = static_cast<std::size_t>(std::ranges::max_element(of, larger) - of.begin());
    std::array<double, 3> axis{};
    axis[main] = of[main] < 0 ? -1 : 1;
    return {axis[0], axis[1], axis[2]};
}

Upward by_planes(const FacingAreas& areas)
{
    const auto any = [](Vec3d) { return true; };
    const Vec3d axis = *areas.best(std::nullopt, any);
    const auto elsewhere = [&](Vec3d other) { return std::abs(dot(axis, other)) < cosine_deg(cameras_deg); };
    const std::optional<Vec3d> next = areas.best(std::nullopt, elsewhere);
    const bool is_level = areas.along(axis) > clearly_more * (next ? areas.along(*next) : 0);
    const double front = areas.along(axis, false);
    const double back = areas.along(axis * -1.0, false);
    if (is_level && std::max(front, back) > clearly_more * std::min(front, back))
        return {axis * (front > back ? 1.0 : -1.0), UpEvidence::planes};
    return {dot(nearest_axis(axis), Vec3d{1, 1, 1}) < 0 ? axis * -1.0 : axis, UpEvidence::nothing};
}

}  // namespace

Upward find_up(const Mesh& mesh, const std::optional<Vec3d>& by_cameras)
{
    const FacingAreas areas(mesh);
    Upward result{by_cameras.value_or(Vec3d{0, 0, 1}), by_cameras ? UpEvidence::cameras : UpEvidence::nothing};
    if (!(areas.area > 0))
        return result;
    if (!by_cameras)
        result = by_planes(areas);
    else
    {
        const auto near_cameras = [&](Vec3d axis) { return std::abs(dot(axis, *by_cameras)) > cosine_deg(cameras_deg); };
        const Vec3d axis = *areas.best(by_cameras, near_cameras);
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

const char* text_of(UpEvidence evidence)
{
    switch (evidence)
    {
    case UpEvidence::cameras_and_plane:
        return "cameras and plane";
    case UpEvidence::cameras:
        return "cameras";
    case UpEvidence::planes:
        return "planes";
    case UpEvidence::nothing:
        return "nothing";
    }
    return "";
}

std::string sentence(const Upward& up)
{
    const std::string floor = fmt::format("the largest level plane is {:.1f}% of the surface", 100 * up.plane_share);
    switch (up.from)
    {
    case UpEvidence::cameras_and_plane:
        return fmt::format("upright by the cameras and the level surfaces, which are {:.1f} degrees apart; {}", up.plane_deg,
                           floor);
    case UpEvidence::cameras:
        return "upright by the cameras; the mesh has no level plane near their direction";
    case UpEvidence::planes:
        return "upright by the mesh's level surfaces, without cameras; " + floor;
    case UpEvidence::nothing:
        break;
    }
    return "the mesh does not show which way is up: its axes are kept; wire 'frames', whose cameras show it, or set up: z";
}

}  // namespace

Vec3d named_axis(std::string_view name)
{
    const double sign = name.starts_with('-') ? -1 : 1;
    switch (name.back())
    {
    case 'x':
        return {sign, 0, 0};
    case 'y':
        return {0, sign, 0};
    default:
        return {0, 0, sign};
    }
}

Upward found_up(const Mesh& mesh, const Input<Frames>& frames, RunContext& run)
{
    std::vector<RigidTransform> poses;
    if (frames.has_value())
        for (const Frame& frame : frames->frames)
            poses.push_back(frame.color.world_from_camera);
    const Upward up = find_up(mesh, poses.empty() ? std::nullopt : cameras_up(poses));
    run.report("up_from", text_of(up.from));
    run.report("up_plane_share", up.plane_share);
    if (up.from == UpEvidence::cameras_and_plane)
        run.report("up_plane_deg", up.plane_deg);
    return up;
}

UprightOption::UprightOption(Configurable* owner)
    : frames_(owner, "frames", optional, "Frames whose cameras show which way is up"),
      up_(owner, "up", "auto", one_of({"auto", "keep", "x", "y", "z", "-x", "-y", "-z"}),
          "World axis that points up and is turned to the file format's; auto: found from the frames' cameras and the mesh's "
          "level surfaces; keep: no rotation")
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
        up = named_axis(*up_);
    run.report("up", Value::List{up.x, up.y, up.z});
    return upright_turn(up, target);
}

Mesh UprightOption::standing(const Mesh& mesh, Vec3d target, RunContext& run) const
{
    const std::array<double, 4> by = turn(mesh, target, run);
    Mesh result = mesh;
    if (by != no_turn)
        for (Vec3f& position : result.positions)
            position = vec_cast<float>(turned(by, vec_cast<double>(position)));
    return result;
}

}  // namespace fresco::geometry
