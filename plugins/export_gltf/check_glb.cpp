#include "check_glb.h"

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
void expect_written(bool good, const std::string& what)
{
    if (!good)
        throw Error("the written file differs from what was to be written: " + what);
}

double largest(Vec3d a)
{
    return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
}

/// The first triangle whose corners are others, or follow each other differently.
void check_triangles(const std::vector<std::uint32_t>& found, const std::vector<std::uint32_t>& meant, bool may_turn)
{
    expect_written(found.size() == meant.size(), fmt::format("{} triangles of {}", found.size() / 3, meant.size() / 3));
    for (std::size_t i = 0; i < meant.size(); i += 3)
    {
        const auto same = [&](std::size_t turn) {
            return found[i] == meant[i + turn] && found[i + 1] == meant[i + (turn + 1) % 3] &&
                   found[i + 2] == meant[i + (turn + 2) % 3];
        };
        expect_written(same(0) || (may_turn && (same(1) || same(2))), fmt::format("triangle {} differs", i / 3));
    }
}
}  // namespace

GlbErrors check_glb(const GlbModel& model, const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options)
{
    expect_written(model.image == image && (image.empty() || model.image_type == options.image_type), "the picture differs");
    expect_written(model.colors == mesh.colors, "the vertex colors differ");
    expect_written(model.texcoords.size() == mesh.texcoords.size(), "the number of texcoords differs");
    expect_written(model.positions.size() == mesh.positions.size(), "the number of vertices differs");
    expect_written(model.normals.empty() == (options.material == GltfMaterial::unlit),
                   "normals present with unlit, or missing with pbr");
    expect_written(model.origin == options.origin, "asset.extras differs");
    check_triangles(model.indices, mesh.indices, options.compress);

    // Half a step, and the rounding of this comparison itself.
    const double step = options.quantize ? double{quantized(mesh).step_m} : 0;
    const double position_limit = step * (0.5 + 1e-9);
    const double normal_limit = options.quantize ? 0.5001 / 127 : 0;
    const double texcoord_limit = options.quantize ? 0.5001 / 65535 + 1e-5 : 0;
    GlbErrors errors;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        const std::string vertex = "vertex " + std::to_string(i);
        const double position = largest(model.positions[i] - vec_cast<double>(mesh.positions[i]));
        expect_written(position <= position_limit, fmt::format("{} is {:f} m away", vertex, position));
        errors.position_m = std::max(errors.position_m, position);
        if (!model.normals.empty())
            expect_written(largest(model.normals[i] - vec_cast<double>(mesh.normals[i])) <= normal_limit,
                           vertex + " has a different normal");
        if (mesh.texcoords.empty())
            continue;
        const Vec2f uv = mesh.texcoords[i];
        // The float that 1 - v is, where floats are written.
        const double v = options.quantize ? 1 - double{uv.y} : double{1 - uv.y};
        const double texcoord = std::max(std::abs(model.texcoords[i].x - double{uv.x}), std::abs(model.texcoords[i].y - v));
        expect_written(texcoord <= texcoord_limit, vertex + " has a different texcoord");
        errors.texcoord = std::max(errors.texcoord, texcoord);
    }
    return errors;
}
