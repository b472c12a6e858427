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

/// Which way is up, unit length: what the cameras' horizontal axes are most nearly perpendicular to, as recorders are held level
/// however far they look down.
Vec3d upwards(const std::vector<Frame>& frames)
{
    // Of a symmetric matrix: the mean of r rᵀ, less a little of m mᵀ, which decides where all cameras look the same way.
    constexpr double share_of_mean = 0.05;
    constexpr int steps = 200;
    const Vec3d mean = mean_direction(frames, {0, -1, 0});
    if (!(length(mean) > 0))
        return {0, 0, 1};
    Vec3d up = normalized(mean);
    // The eigenvector of the smallest eigenvalue, none of which is more than one.
    for (int step = 0; step < steps; ++step)
    {
        Vec3d product = mean * (-share_of_mean * dot(mean, up));
        for (const Frame& frame : frames)
        {
            const Vec3d right = frame.color.world_from_camera.direction({1, 0, 0});
            product += right * (dot(right, up) / static_cast<double>(frames.size()));
        }
        up = normalized(up - product);
    }
    return dot(up, mean) < 0 ? up * -1.0 : up;
}

}  // namespace

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
    Value::Map cameras = pose_of(frames.front().color);
    cameras[2].second = triple(upwards(frames));
    cameras.emplace_back("looking", triple(mean_direction(frames, {0, 0, 1})));
    page.set("cameras", std::move(cameras));
    for (const Frame* frame : shown)
        page.picture(frame->sequence + "_" + frame->name, load_color(*frame, &page.images), {{"pose", pose_of(frame->color)}});
}

}  // namespace fresco
