#include "stroke_limits.h"

#include <fresco/error.h>
#include <fresco/geometry/topology.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace fresco::synthesize
{
namespace
{

constexpr double least_texels = 2;
constexpr const char* check_unit = "; if the mesh is not in meters, say so where it is read (scan.mesh: unit_m)";

double longest_side_m(const Mesh& mesh)
{
    Vec3f low = mesh.positions[mesh.triangles[0][0]];
    Vec3f high = low;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle)
        {
            const Vec3f p = mesh.positions[corner];
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
    return double{std::max({high.x - low.x, high.y - low.y, high.z - low.z})};
}

}  // namespace

double mean_texel_m(const Mesh& mesh, int size_px)
{
    double area = 0;
    double uv_area = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const Vec2f* uv = &mesh.texcoords[3 * f];
        const Vec2d a{double{uv[1].x} - uv[0].x, double{uv[1].y} - uv[0].y};
        const Vec2d b{double{uv[2].x} - uv[0].x, double{uv[2].y} - uv[0].y};
        uv_area += std::abs(cross(a, b));
        area += length(geometry::area_vector(mesh, f));
    }
    if (!(uv_area > 0) || !(area > 0))
        throw Error("the charts of the mesh on port 'mesh' have no area: wire an atlas.* stage");
    return std::sqrt(area / uv_area) / size_px;
}

void check_stroke_width(const Mesh& mesh, double stroke_m, double texel_m)
{
    if (stroke_m < least_texels * texel_m)
        throw Error(fmt::format("strokes of {:.6g} cm are too narrow for texels of {:.3g} cm: they need at "
                                "least {:g} texels, so use a stroke_cm of {:.3g} or more, or a larger size_px{}",
                                stroke_m * 100, texel_m * 100, least_texels, least_texels * texel_m * 100, check_unit));
    if (const double room_m = longest_side_m(mesh); stroke_m > room_m)
        throw Error(fmt::format("strokes of {:.6g} cm are wider than the room, which is {:.3g} cm long: use "
                                "a smaller stroke_cm{}",
                                stroke_m * 100, room_m * 100, check_unit));
}

}  // namespace fresco::synthesize
