#include "painted_surface.h"

#include <fresco/error.h>
#include <fresco/geometry/charts.h>
#include <fresco/images/recoloring.h>
#include <fresco/texturing/face_frame.h>
#include <fresco/texturing/surface_fill.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco::synthesize
{
namespace
{

/// Per axis, how much of the surface faces along it (within about 25 degrees), either way.
double facing(const PaintedSurface& surface, Vec3f axis)
{
    double sum = 0;
    for (std::size_t f = 0; f < surface.areas.size(); ++f)
    {
        const double along = std::abs(dot(surface.normals[f], axis));
        sum += surface.areas[f] * std::pow(along, 16);
    }
    return sum;
}

Vec3f any_perpendicular(Vec3f axis)
{
    const Vec3f other = std::abs(axis.x) < 0.7F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0};
    return normalized(cross(axis, other));
}

/// Direction around `axis` that most of the surface faces, to one degree.
Vec3f ahead_of(const PaintedSurface& surface, Vec3f axis)
{
    // A fourfold angle: walls at right angles point the same way.
    const Vec3f x = any_perpendicular(axis);
    const Vec3f y = cross(axis, x);
    Vec2d sum;
    for (std::size_t f = 0; f < surface.areas.size(); ++f)
    {
        const Vec2d flat{dot(surface.normals[f], x), dot(surface.normals[f], y)};
        const double horizontal = length(flat);
        if (horizontal < 0.9)
            continue;
        const double angle = 4 * std::atan2(flat.y, flat.x);
        sum = sum + Vec2d{std::cos(angle), std::sin(angle)} * surface.areas[f];
    }
    const double angle = dot(sum, sum) > 0 ? std::atan2(sum.y, sum.x) / 4 : 0.0;
    const Vec3f one = x * static_cast<float>(std::cos(angle)) + y * static_cast<float>(std::sin(angle));
    const Vec3f other = cross(axis, one);
    return facing(surface, other) > facing(surface, one) ? other : one;
}

/// Orients a line along the coordinate axis that it is nearest to, so that its sign does not depend on chance.
Vec3f positive(Vec3f axis)
{
    const std::array<float, 3> c{axis.x, axis.y, axis.z};
    std::size_t main = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::abs(c[i]) > std::abs(c[main]))
            main = i;
    return c[main] < 0 ? -axis : axis;
}

}  // namespace

PaintedSurface::PaintedSurface(const Mesh& of, const Progress& progress) : mesh(of), charts(texturing::find_charts(of))
{
    Mesh joined = texturing::welded(of);
    // A face that is folded to a line loses its edges, so that those beside it are neighbors.
    for (Triangle& t : joined.triangles)
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
            t.fill(t[0]);
    const geometry::Surface surface(joined);
    neighbors = surface.neighbors;
    areas = surface.areas;
    for (const Vec3d normal : geometry::smoothed_normals(surface, progress))
        normals.push_back(vec_cast<float>(normal));

    std::vector<double> area(charts.count, 0.0);
    std::vector<double> uv_area(charts.count, 0.0);
    for (std::uint32_t f = 0; f < surface.areas.size(); ++f)
    {
        area[charts.of_face[f]] += surface.areas[f];
        uv_area[charts.of_face[f]] += std::abs(texturing::FaceFrame(of, f, 1).area) / 2;
    }
    for (std::size_t c = 0; c < area.size(); ++c)
        uv_per_m.push_back(area[c] > 0 ? std::sqrt(uv_area[c] / area[c]) : 0.0);
}

std::pair<Vec3f, Vec3f> texcoord_axes(const Mesh& mesh, std::size_t face)
{
    const Vec2f* uv = &mesh.texcoords[3 * face];
    const Triangle& t = mesh.triangles[face];
    const Vec2f a = uv[1] - uv[0];
    const Vec2f b = uv[2] - uv[0];
    const float area = cross(a, b);
    if (area == 0)
        return {};
    const Vec3f first = mesh.positions[t[1]] - mesh.positions[t[0]];
    const Vec3f second = mesh.positions[t[2]] - mesh.positions[t[0]];
    return {(first * b.y - second * a.y) * (1 / area), (second * a.x - first * b.x) * (1 / area)};
}

Upright upright(const PaintedSurface& surface, Vec3f up)
{
    const Vec3f axis = normalized(up);
    return {axis, positive(ahead_of(surface, axis))};
}

TangentFrame frame_at(Vec3f normal, const Upright& upright)
{
    constexpr float level = 0.70710678F;
    const Vec3f top = std::abs(dot(normal, upright.up)) > level ? upright.ahead : upright.up;
    const Vec3f along = top - normal * dot(top, normal);
    const Vec3f up = dot(along, along) > 1e-12F ? normalized(along) : any_perpendicular(normal);
    return {cross(up, normal), -up, normal};
}

StartPicture::StartPicture(const PaintedSurface& surface, const Texture& texture, const Progress& progress) : surface_(surface)
{
    texturing::check_texture(texture);
    rgb_ = texturing::collapse(texture, progress);
    faces_ = texturing::find_texel_faces(surface.mesh, surface.charts, texture.size_px(), progress);
    std::vector<std::uint8_t> known = texture.seen.values;
    for (std::size_t texel = 0; texel < known.size(); ++texel)
    {
        known[texel] = known[texel] != 0 ? 1 : 0;
        if (faces_.inside[texel] != 0)
        {
            ++chart_texels_;
            known_texels_ += known[texel];
        }
    }
    if (known_texels_ == 0)
        throw Error("the texture on port 'start' has no texel of the mesh: check that it was made for this atlas and that its "
                    "frames see the mesh");
    texturing::fill_unseen(surface.mesh, surface.charts, faces_, known, rgb_, progress);
}

void StartPicture::recolor(const Raster8& picture, const Raster8& opaque)
{
    ColorMoments from;
    for (std::size_t texel = 0; texel < faces_.inside.size(); ++texel)
        if (faces_.inside[texel] != 0)
            from.add({double{rgb_.values[3 * texel]}, double{rgb_.values[3 * texel + 1]}, double{rgb_.values[3 * texel + 2]}});
    const Recoloring recolored(from, picture, opaque.values);
    for (std::size_t i = 0; i + 2 < rgb_.values.size(); i += 3)
    {
        const Vec3f color = recolored({rgb_.values[i], rgb_.values[i + 1], rgb_.values[i + 2]});
        rgb_.values[i] = color.x;
        rgb_.values[i + 1] = color.y;
        rgb_.values[i + 2] = color.z;
    }
}

Vec3f StartPicture::bilinear(std::uint32_t chart, double x, double y, float& weight) const
{
    Vec3f sum;
    const double left = std::floor(x - 0.5);
    const double top = std::floor(y - 0.5);
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
        {
            const int column = std::clamp(static_cast<int>(left) + i, 0, rgb_.width - 1);
            const int row = std::clamp(static_cast<int>(top) + j, 0, rgb_.height - 1);
            const auto texel =
                static_cast<std::size_t>(row) * static_cast<std::size_t>(rgb_.width) + static_cast<std::size_t>(column);
            if (!faces_.covered(texel) || surface_.charts.of_face[faces_.face[texel]] != chart)
                continue;
            const double across = i == 0 ? left + 1.5 - x : x - 0.5 - left;
            const double along = j == 0 ? top + 1.5 - y : y - 0.5 - top;
            // Never quite nothing, so that a lone texel of the chart counts.
            const auto share = static_cast<float>(across * along + 1e-4);
            weight += share;
            sum += Vec3f{rgb_.values[3 * texel], rgb_.values[3 * texel + 1], rgb_.values[3 * texel + 2]} * share;
        }
    return sum;
}

Vec3f StartPicture::at(std::uint32_t chart, Vec2f uv, double footprint) const
{
    const double x = double{uv.x} * rgb_.width;
    const double y = (1 - double{uv.y}) * rgb_.height;
    const double texels = footprint * rgb_.width;
    const int steps = std::clamp(static_cast<int>(std::lround(texels)), 1, 16);
    Vec3f sum;
    float weight = 0;
    for (int j = 0; j < steps; ++j)
        for (int i = 0; i < steps; ++i)
            sum += bilinear(chart, x + ((i + 0.5) / steps - 0.5) * texels, y + ((j + 0.5) / steps - 0.5) * texels, weight);
    if (weight > 0)
        return sum * (1 / weight);
    // A sliver of a chart that no texel of this size belongs to.
    const int column = std::clamp(static_cast<int>(x), 0, rgb_.width - 1);
    const int row = std::clamp(static_cast<int>(y), 0, rgb_.height - 1);
    return {rgb_.at(column, row, 0), rgb_.at(column, row, 1), rgb_.at(column, row, 2)};
}

}  // namespace fresco::synthesize
