#include "convention.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace fresco::inspect
{
namespace
{

std::vector<Mat3> make_axis_rotations()
{
    std::vector<Mat3> all;
    std::array<std::size_t, 3> axes{0, 1, 2};
    do
        for (const int signs : {0, 6, 1, 2, 3, 4, 5, 7})  // 6: y and z turned round.
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

RigidTransform Convention::correct(const RigidTransform& recorded) const
{
    RigidTransform pose = inverted ? recorded.inverse() : recorded;
    pose.translation = pose.translation * scale;
    pose.rotation = pose.rotation * camera_turn;
    return RigidTransform{world_turn, {}} * pose;
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

std::vector<Convention> candidate_conventions(bool rare)
{
    const auto& turns = axis_rotations();
    const std::span<const Mat3> usual(turns.data(), 2);
    const Mat3 same;
    constexpr std::array scales{1.0, 0.001, 1000.0, 0.01, 100.0};
    std::vector<Convention> all;
    for (const double scale : scales)
        for (const bool inverted : {false, true})
            for (const Mat3& camera : usual)
                if (scale != 1 || inverted || !(camera == same))
                    all.push_back({inverted, scale, camera, same});
    if (!rare)
        return all;
    for (const Mat3& world : std::span(turns).subspan(1))
        for (const bool inverted : {false, true})
            for (const Mat3& camera : usual)
                all.push_back({inverted, 1, camera, world});
    for (const double scale : scales)
        for (const bool inverted : {false, true})
            for (const Mat3& camera : std::span(turns).subspan(2))
                all.push_back({inverted, scale, camera, same});
    return all;
}

double usual_scale(double scale)
{
    for (const double usual : {1000.0, 0.001, 0.25, 0.2, 4.0, 5.0, 100.0, 0.01, 10.0, 0.1, 0.3048, 3.2808})
        if (std::abs(std::log(scale / usual)) < 0.07)
            return usual;
    return scale;
}

}  // namespace fresco::inspect
