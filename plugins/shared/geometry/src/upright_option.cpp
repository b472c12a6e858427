#include <fresco/geometry/upright_option.h>

#include <fresco/camera.h>

#include <charconv>

namespace fresco::geometry
{
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

std::string one_decimal(double value)
{
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 1).ptr};
}

std::string sentence(const Upward& up)
{
    const std::string floor = "the largest level plane is " + one_decimal(100 * up.plane_share) + "% of the surface";
    switch (up.from)
    {
    case UpEvidence::cameras_and_plane:
        return "upright by the cameras and the level surfaces, which are " + one_decimal(up.plane_deg) + " degrees apart; " +
               floor;
    case UpEvidence::cameras:
        return "upright by the cameras; the mesh has no level plane near their direction";
    case UpEvidence::planes:
        return "upright by the mesh's level surfaces, without cameras; " + floor;
    case UpEvidence::nothing:
        break;
    }
    return "the mesh does not show which way is up: its axes are kept; wire 'frames', whose cameras show it, or set up: z";
}

void report_up(Vec3d up, RunContext& run)
{
    run.report("up", Value::List{up.x, up.y, up.z});
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
    report_up(up, run);
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
