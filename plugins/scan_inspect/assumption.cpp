#include "assumption.h"

#include <fresco/numerics/rotations.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco::inspect
{
namespace
{

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

Mat3 rotation(const Quaternion& q)
{
    return numerics::rotation_of(q[0], q[1], q[2], q[3]);
}

/// The rotation whose quaternion was read in the other order.
Mat3 reordered(const Mat3& recorded, bool scalar_first)
{
    const auto [w, x, y, z] = quaternion(recorded);
    // Read as x y z w, the file's four numbers were x y z w; read as w x y z, they were w x y z.
    return scalar_first ? rotation({x, y, z, w}) : rotation({z, w, x, y});
}

RigidTransform between(const RigidTransform& a, const RigidTransform& b, double share)
{
    const Quaternion from = quaternion(a.rotation);
    Quaternion to = quaternion(b.rotation);
    double same = 0;
    for (std::size_t i = 0; i < 4; ++i)
        same += from[i] * to[i];
    Quaternion middle;
    double norm = 0;
    for (std::size_t i = 0; i < 4; ++i)
    {
        middle[i] = (1 - share) * from[i] + share * (same < 0 ? -to[i] : to[i]);
        norm += middle[i] * middle[i];
    }
    for (double& value : middle)
        value /= std::sqrt(norm);
    return {rotation(middle), a.translation * (1 - share) + b.translation * share};
}

RigidTransform delayed(const PoseTrack& track, Reading reading, double lag)
{
    const auto last = static_cast<double>(track.poses.size() - 1);
    const double place = std::clamp(static_cast<double>(track.own) + lag, 0.0, last);
    const auto before = static_cast<std::size_t>(place);
    const double share = place - static_cast<double>(before);
    const RigidTransform first = meant(track.poses[before], reading);
    return share > 0 ? between(first, meant(track.poses[before + 1], reading), share) : first;
}

std::vector<Mat3> make_axis_rotations()
{
    std::vector<Mat3> all;
    std::array<std::size_t, 3> axes{0, 1, 2};
    do
        for (const int signs : {0, 6, 1, 2, 3, 4, 5, 7})  // 6: y and z negated.
        {
            Mat3 turn;
            turn.m.fill(0);
            for (std::size_t column = 0; column < 3; ++column)
                turn.m[3 * axes[column] + column] = (static_cast<unsigned>(signs) >> column & 1U) != 0 ? -1 : 1;
            if (determinant(turn) > 0)
                all.push_back(turn);
        }
    while (std::ranges::next_permutation(axes).found);
    return all;
}

}  // namespace

RigidTransform meant(const RigidTransform& recorded, Reading reading)
{
    const auto ordered = [](RigidTransform pose, bool scalar_first)
    {
        pose.rotation = reordered(pose.rotation, scalar_first);
        return pose;
    };
    switch (reading)
    {
    case Reading::inverted:
        return recorded.inverse();
    case Reading::transposed:
        return {transposed(recorded.rotation), recorded.translation};
    case Reading::scalar_first:
        return ordered(recorded, true);
    case Reading::scalar_last:
        return ordered(recorded, false);
    case Reading::inverted_scalar_first:
        return ordered(recorded.inverse(), true).inverse();
    case Reading::inverted_scalar_last:
        return ordered(recorded.inverse(), false).inverse();
    default:
        return recorded;
    }
}

RigidTransform Assumption::pose(const PoseTrack& track) const
{
    RigidTransform pose = delayed(track, reading, lag_frames);
    pose.translation = pose.translation * pose_scale;
    pose.rotation = pose.rotation * camera_turn;
    return move * (RigidTransform{world_turn, {}} * pose);
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
    static const std::vector<Mat3> all = make_axis_rotations();
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
        if (std::abs(std::log(scale / usual)) < 0.04)
            return usual;
    return scale;
}

}  // namespace fresco::inspect
