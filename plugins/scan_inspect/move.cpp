#include "move.h"

#include <fresco/raycast/surface.h>

#include <array>
#include <cmath>
#include <span>

namespace fresco::inspect
{
namespace
{

using Vector6 = std::array<double, 6>;

/// Normal equations of the twist (rotation about `center`, then shift).
struct Equations
{
    std::array<Vector6, 6> matrix{};
    Vector6 right{};

    void add(const Vector6& row, double residual, double weight)
    {
        for (std::size_t i = 0; i < 6; ++i)
        {
            for (std::size_t j = 0; j < 6; ++j)
                matrix[i][j] += weight * row[i] * row[j];
            right[i] += weight * row[i] * residual;
        }
    }

    /// By elimination; what no measurement holds stays where it is.
    Vector6 solved()
    {
        for (std::size_t i = 0; i < 6; ++i)
            matrix[i][i] = matrix[i][i] * (1 + 1e-6) + 1e-9;
        for (std::size_t i = 0; i < 6; ++i)
            for (std::size_t j = i + 1; j < 6; ++j)
            {
                const double factor = matrix[j][i] / matrix[i][i];
                for (std::size_t k = i; k < 6; ++k)
                    matrix[j][k] -= factor * matrix[i][k];
                right[j] -= factor * right[i];
            }
        Vector6 x{};
        for (std::size_t i = 6; i-- > 0;)
        {
            x[i] = right[i];
            for (std::size_t k = i + 1; k < 6; ++k)
                x[i] -= matrix[i][k] * x[k];
            x[i] /= matrix[i][i];
        }
        return x;
    }
};

/// A rotation by the vector's length about its direction (Rodrigues).
Mat3 rotation_by(Vec3d turn)
{
    const double angle = length(turn);
    const Vec3d axis = normalized(turn);
    const double s = std::sin(angle);
    const double c = 1 - std::cos(angle);
    Mat3 r;
    r.m = {1 - c * (axis.y * axis.y + axis.z * axis.z),
           c * axis.x * axis.y - s * axis.z,
           c * axis.x * axis.z + s * axis.y,
           c * axis.x * axis.y + s * axis.z,
           1 - c * (axis.x * axis.x + axis.z * axis.z),
           c * axis.y * axis.z - s * axis.x,
           c * axis.x * axis.z - s * axis.y,
           c * axis.y * axis.z + s * axis.x,
           1 - c * (axis.x * axis.x + axis.y * axis.y)};
    return r;
}

struct Pair
{
    Vec3d point;
    Vec3d normal;
    double offset = 0;  ///< Of the face from the point, along the normal.
    double depth = 0;
};

void add_pairs(const raycast::Scene& scene, const DepthView& view, const Assumption& assumption, std::size_t stride,
               std::vector<Pair>& pairs)
{
    const RigidTransform pose = depth_pose(view, assumption);
    std::array<Vec3d, raycast::Scene::packet_size> directions;
    std::array<double, raycast::Scene::packet_size> depths{};
    std::array<raycast::Hit, raycast::Scene::packet_size> hits;
    for (std::size_t begin = 0; begin < view.samples.size();)
    {
        std::size_t count = 0;
        for (; begin < view.samples.size() && count < directions.size(); begin += stride, ++count)
        {
            const MeasuredRay ray = measured_ray(view, view.samples[begin], assumption);
            directions[count] = pose.direction(ray.direction);
            depths[count] = ray.depth * assumption.depth_scale;
        }
        scene.cast(pose.translation, std::span(directions).first(count), std::span(hits).first(count));
        for (std::size_t i = 0; i < count; ++i)
            if (hits[i].found())
            {
                const auto corners = raycast::corners(scene.mesh(), hits[i].triangle);
                const Vec3d normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
                pairs.push_back({pose.translation + directions[i] * depths[i], normal,
                                 dot(normal, directions[i]) * (hits[i].distance - depths[i]), depths[i]});
            }
    }
}

}  // namespace

RigidTransform best_move(const raycast::Scene& scene, const std::vector<DepthView>& views, const Assumption& assumption,
                         std::size_t stride)
{
    Assumption moved = assumption;
    for (const double reach : {0.2, 0.2, 0.15, 0.15, 0.1, 0.1, 0.06, 0.06, 0.04, 0.04})
    {
        std::vector<Pair> pairs;
        for (const DepthView& view : views)
            add_pairs(scene, view, moved, stride, pairs);
        Vec3d center;
        for (const Pair& pair : pairs)
            center += pair.point * (1.0 / static_cast<double>(pairs.size()));
        Equations equations;
        for (const Pair& pair : pairs)
        {
            const double share = pair.offset / (pair.depth * reach);
            if (std::abs(share) >= 1)
                continue;
            const Vec3d turn = cross(pair.point - center, pair.normal);
            const double weight = (1 - share * share) * (1 - share * share) / (pair.depth * pair.depth);
            equations.add({turn.x, turn.y, turn.z, pair.normal.x, pair.normal.y, pair.normal.z}, pair.offset, weight);
        }
        const Vector6 x = equations.solved();
        const Mat3 turn = rotation_by({x[0], x[1], x[2]});
        const Vec3d shift{x[3], x[4], x[5]};
        moved.move = RigidTransform{turn, center + shift - turn * center} * moved.move;
    }
    return moved.move;
}

}  // namespace fresco::inspect
