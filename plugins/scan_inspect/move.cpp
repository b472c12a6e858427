#include "move.h"

#include <fresco/numerics/rotations.h>
#include <fresco/numerics/solve_symmetric.h>
#include <fresco/raycast/surface.h>

#include <array>
#include <cmath>

namespace fresco::inspect
{
namespace
{

struct Pair
{
    Vec3d point;
    Vec3d normal;
    double offset = 0;  ///< Of the face from the point, along the normal.
    double depth = 0;
};

std::vector<Pair> pairs_of(const raycast::Scene& scene, const std::vector<DepthView>& views, const Assumption& assumption,
                           std::size_t stride)
{
    std::vector<Pair> pairs;
    for (const DepthView& view : views)
        cast_samples(scene, view, assumption, stride,
                     [&](const WorldRay& ray, const raycast::Hit& hit)
                     {
                         if (!hit.found())
                             return;
                         const auto corners = raycast::corners(scene.mesh(), hit.triangle);
                         const Vec3d normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
                         const double depth = ray.depth * assumption.depth_scale;
                         pairs.push_back({ray.origin + ray.direction * depth, normal,
                                          dot(normal, ray.direction) * (hit.distance - depth), depth});
                     });
    return pairs;
}

}  // namespace

RigidTransform best_move(const raycast::Scene& scene, const std::vector<DepthView>& views, const Assumption& assumption,
                         std::size_t stride)
{
    Assumption moved = assumption;
    for (const double reach : {0.2, 0.2, 0.15, 0.15, 0.1, 0.1, 0.06, 0.06, 0.04, 0.04})
    {
        const std::vector<Pair> pairs = pairs_of(scene, views, moved, stride);
        Vec3d center;
        for (const Pair& pair : pairs)
            center += pair.point * (1.0 / static_cast<double>(pairs.size()));
        // Normal equations of the twist: rotation about the center, then shift.
        std::array<double, 36> matrix{};
        std::array<double, 6> x{};
        for (const Pair& pair : pairs)
        {
            const double share = pair.offset / (pair.depth * reach);
            if (std::abs(share) >= 1)
                continue;
            const Vec3d turn = cross(pair.point - center, pair.normal);
            const double weight = (1 - share * share) * (1 - share * share) / (pair.depth * pair.depth);
            const std::array row{turn.x, turn.y, turn.z, pair.normal.x, pair.normal.y, pair.normal.z};
            for (std::size_t i = 0; i < 6; ++i)
            {
                for (std::size_t j = 0; j < 6; ++j)
                    matrix[6 * i + j] += weight * row[i] * row[j];
                x[i] += weight * row[i] * pair.offset;
            }
        }
        // What no measurement holds stays where it is.
        for (std::size_t i = 0; i < 6; ++i)
            matrix[7 * i] = matrix[7 * i] * (1 + 1e-6) + 1e-9;
        numerics::solve_symmetric(matrix, x);
        const Mat3 turn = numerics::rotation_by({x[0], x[1], x[2]});
        const Vec3d shift{x[3], x[4], x[5]};
        moved.move = RigidTransform{turn, center + shift - turn * center} * moved.move;
    }
    return moved.move;
}

}  // namespace fresco::inspect
