#include <fresco/cameras_up.h>
#include <fresco/frames.h>
#include <fresco/preview.h>

#include <map>

namespace fresco
{
namespace
{

Value triple(Vec3d v)
{
    return Value::List{v.x, v.y, v.z};
}

Value::Map pose_of(const Camera& camera)
{
    const RigidTransform& world_from_camera = camera.world_from_camera;
    return {{"position", triple(world_from_camera.translation)},
            {"forward", triple(world_from_camera.direction({0, 0, 1}))},
            {"up", triple(world_from_camera.direction({0, -1, 0}))}};
}

/// The mean of a camera's axis over all frames.
Vec3d mean_direction(const std::vector<Frame>& frames, Vec3d axis)
{
    Vec3d mean;
    for (const Frame& frame : frames)
        mean += frame.color.world_from_camera.direction(axis) * (1.0 / static_cast<double>(frames.size()));
    return mean;
}

std::vector<RigidTransform> poses_of(const std::vector<Frame>& frames)
{
    std::vector<RigidTransform> poses;
    for (const Frame& frame : frames)
        poses.push_back(frame.color.world_from_camera);
    return poses;
}

}  // namespace

Value page_cameras(const Frames& frames)
{
    Value::Map cameras = pose_of(frames.frames.at(0).color);
    cameras[2].second = triple(cameras_up(poses_of(frames.frames)).value_or(Vec3d{0, 0, 1}));
    cameras.emplace_back("looking", triple(mean_direction(frames.frames, {0, 0, 1})));
    return cameras;
}

void Frames::preview(Preview& page) const
{
    std::map<std::string, const Frame*> recorded;
    for (const Frame& frame : frames)
        if (!frame.color_picture.empty())
            recorded.emplace(frame.sequence + "_" + frame.name, &frame);
    std::vector<const Frame*> shown;
    for (const std::string& name : page.names)
        if (const auto found = recorded.find(std::filesystem::path(name).stem().string()); found != recorded.end())
        {
            shown.push_back(found->second);
            recorded.erase(found);  // Several stages may have made pictures of it.
        }
    if (frames.empty() || (shown.empty() && !page.last))
        return;
    page.set("cameras", page_cameras(*this));
    for (const Frame* frame : shown)
        page.picture(frame->sequence + "_" + frame->name, load_color(*frame, &page.images), {{"pose", pose_of(frame->color)}});
}

}  // namespace fresco
