#include "metadata.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/value.h>

#include <algorithm>
#include <string>
#include <utility>

namespace record3d
{
namespace
{

using namespace fresco;
using recordings::quaternion_transform;

bool is_nan(const JsonPlace& entry)
{
    return entry.value().is_null() || (entry.value().is_number() && !std::isfinite(entry.value().as_double()));
}

std::optional<RigidTransform> pose_of(const JsonPlace& place)
{
    if (std::ranges::any_of(place.list(7), is_nan))
        return std::nullopt;
    const auto p = place.numbers(7);
    return quaternion_transform(p[3], p[0], p[1], p[2], {p[4], p[5], p[6]}, place.place());
}

bool is_same(const RigidTransform& a, const RigidTransform& b)
{
    constexpr double step = 1e-6;
    double most = length(a.translation - b.translation);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            most = std::max(most, std::abs(a.rotation(row, column) - b.rotation(row, column)));
    return most < step;
}

std::vector<Intrinsics> cameras_of(const JsonPlace& root, int width, int height, std::size_t pictures)
{
    std::vector<Intrinsics> cameras;
    if (const auto coefficients = root.find("perFrameIntrinsicCoeffs"); coefficients && !coefficients->list().empty())
        for (const auto& place : coefficients->list(pictures))
        {
            const auto c = place.numbers(4);
            cameras.push_back({width, height, c[0], c[1], c[2], c[3]});
        }
    else
    {
        const auto place = root["K"];
        auto k = place.numbers(9);
        std::swap(k[2], k[6]);
        std::swap(k[5], k[7]);
        std::swap(k[1], k[3]);
        cameras.push_back(recordings::intrinsics_from_matrix(k, recordings::PixelCenter::half, width, height, place.place()));
    }
    return cameras;
}

}  // namespace

Metadata parse_metadata(std::string_view text, std::string_view source)
{
    const auto parsed = recordings::parse_recorded_json(text, source);
    const JsonPlace root(parsed, std::string(source));
    const int width = root["w"].size(), height = root["h"].size();
    Metadata metadata{.depth_width = width < height ? 192 : 256, .depth_height = width < height ? 256 : 192};
    if (root.find("dw") || root.find("dh"))
    {
        constexpr int most_px = 4096;
        metadata.depth_width = static_cast<int>(root["dw"].integer(1, most_px));
        metadata.depth_height = static_cast<int>(root["dh"].integer(1, most_px));
    }
    const auto poses = root["poses"];
    for (const auto& place : poses.list())
        metadata.world_from_camera.push_back(pose_of(place));
    const auto& all = metadata.world_from_camera;
    metadata.cameras = cameras_of(root, width, height, all.size());
    if (all.empty())
        poses.fail("expected the pose of each picture");
    if (all.size() > 1 &&
        std::ranges::all_of(all, [&](const auto& pose) { return pose && all.front() && is_same(*pose, *all.front()); }))
        poses.fail("all poses are the same: Record3D tracks no poses with the front camera; record with the LiDAR scanner");
    RigidTransform world_from_poses;
    if (const auto start = root.find("initPose"); start && all.front() && is_same(*all.front(), {}))
        world_from_poses = pose_of(*start).value_or(RigidTransform{});
    const RigidTransform gl_from_cv{Mat3{{1, 0, 0, 0, -1, 0, 0, 0, -1}}, {}};
    for (auto& pose : metadata.world_from_camera)
        if (pose)
            pose = world_from_poses * *pose * gl_from_cv;
    return metadata;
}

}  // namespace record3d
