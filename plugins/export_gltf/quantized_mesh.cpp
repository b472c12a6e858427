#include "quantized_mesh.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <string>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{
constexpr double last_step = 65535;
constexpr double texcoord_rounding = 1e-5;

struct Box
{
    Vec3f low;
    Vec3f high;
};

Box bounding_box(const std::vector<Vec3f>& positions)
{
    constexpr float far = std::numeric_limits<float>::infinity();
    Box box{{far, far, far}, {-far, -far, -far}};
    for (const Vec3f p : positions)
    {
        box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
        box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
    }
    return box;
}

/// The least float that reaches the box's far side in 65535 steps; 1 for a box without extent.
float step_for(const Box& box)
{
    const Vec3d extent = vec_cast<double>(box.high) - vec_cast<double>(box.low);
    const double longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0))
        return 1;
    auto step = static_cast<float>(longest / last_step);
    if (double{step} * last_step < longest)
        step = std::nextafter(step, std::numeric_limits<float>::infinity());
    return step;
}

std::uint16_t nearest_step(double steps)
{
    return static_cast<std::uint16_t>(std::lround(std::clamp(steps, 0.0, last_step)));
}

std::uint16_t texcoord_step(double at)
{
    if (!(at >= -texcoord_rounding && at <= 1 + texcoord_rounding))
        throw Error(
            fmt::format("option \"quantize\": a texcoord is {:.6g}; expected 0 to 1: set quantize: false for this mesh", at));
    return nearest_step(at * last_step);
}

std::int8_t normal_step(float component)
{
    return static_cast<std::int8_t>(std::lround(double{component} * 127));
}
}  // namespace

QuantizedMesh quantized(const WeldedMesh& mesh)
{
    const Box box = bounding_box(mesh.positions);
    QuantizedMesh result;
    result.origin = box.low;
    result.step_m = step_for(box);
    const auto along = [&](float p, float low) { return nearest_step((double{p} - double{low}) / double{result.step_m}); };
    for (const Vec3f p : mesh.positions)
        result.positions.push_back({along(p.x, box.low.x), along(p.y, box.low.y), along(p.z, box.low.z), 0});
    for (const Vec3f n : mesh.normals)
        result.normals.push_back({normal_step(n.x), normal_step(n.y), normal_step(n.z), 0});
    for (const Vec2f uv : mesh.texcoords)
        result.texcoords.push_back({texcoord_step(double{uv.x}), texcoord_step(1 - double{uv.y})});
    return result;
}
