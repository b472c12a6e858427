#include "painted_surface.h"

#include <fresco/geometry/charts.h>

#include <array>
#include <cmath>

namespace fresco::synthesize
{
namespace
{

/// The same surface with one vertex per position, so that faces on both sides of a seam are neighbors. A face that is folded to
/// a line loses its edges, so that those beside it are neighbors too.
Mesh welded(const Mesh& mesh)
{
    const std::vector<std::uint32_t> vertex = texturing::welded_vertices(mesh);
    Mesh result;
    result.positions = mesh.positions;
    result.triangles = mesh.triangles;
    for (Triangle& triangle : result.triangles)
    {
        for (std::uint32_t& corner : triangle)
            corner = vertex[corner];
        if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
            triangle.fill(triangle[0]);
    }
    return result;
}

double texcoord_area(const Mesh& mesh, std::size_t face)
{
    const Vec2f* uv = &mesh.texcoords[3 * face];
    const Vec2d a{double{uv[1].x} - uv[0].x, double{uv[1].y} - uv[0].y};
    const Vec2d b{double{uv[2].x} - uv[0].x, double{uv[2].y} - uv[0].y};
    return std::abs(cross(a, b)) / 2;
}

/// Per axis, how much of the surface faces along it (within about 25 degrees), either way.
double facing(const PaintedSurface& surface, const std::vector<double>& areas, Vec3f axis)
{
    double sum = 0;
    for (std::size_t f = 0; f < areas.size(); ++f)
    {
        const double along = std::abs(dot(surface.normals[f], axis));
        sum += areas[f] * std::pow(along, 16);
    }
    return sum;
}

Vec3f any_perpendicular(Vec3f axis)
{
    const Vec3f other = std::abs(axis.x) < 0.7F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0};
    return normalized(cross(axis, other));
}

/// Of the directions around `axis`, the one that most of the surface faces along, to a degree.
Vec3f ahead_of(const PaintedSurface& surface, const std::vector<double>& areas, Vec3f axis)
{
    // A fourfold angle: walls at right angles point the same way.
    const Vec3f x = any_perpendicular(axis);
    const Vec3f y = cross(axis, x);
    Vec2d sum;
    for (std::size_t f = 0; f < areas.size(); ++f)
    {
        const Vec2d flat{dot(surface.normals[f], x), dot(surface.normals[f], y)};
        const double horizontal = length(flat);
        if (horizontal < 0.9)
            continue;
        const double angle = 4 * std::atan2(flat.y, flat.x);
        sum = sum + Vec2d{std::cos(angle), std::sin(angle)} * areas[f];
    }
    const double angle = dot(sum, sum) > 0 ? std::atan2(sum.y, sum.x) / 4 : 0.0;
    const Vec3f one = x * static_cast<float>(std::cos(angle)) + y * static_cast<float>(std::sin(angle));
    const Vec3f other = cross(axis, one);
    return facing(surface, areas, other) > facing(surface, areas, one) ? other : one;
}

std::vector<double> face_areas(const Mesh& mesh)
{
    std::vector<double> areas(mesh.triangles.size());
    for (std::size_t f = 0; f < areas.size(); ++f)
        areas[f] = length(geometry::area_vector(mesh, f)) / 2;
    return areas;
}

/// The same line, pointing along the coordinate axis that it is nearest to, so that it does not depend on chance.
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
    const Mesh joined = welded(of);
    const geometry::Surface surface(joined);
    neighbors = surface.neighbors;
    for (const Vec3d normal : geometry::smoothed_normals(surface, progress))
        normals.push_back(vec_cast<float>(normal));

    std::vector<double> area(charts.count, 0.0);
    std::vector<double> uv_area(charts.count, 0.0);
    for (std::size_t f = 0; f < surface.areas.size(); ++f)
    {
        area[charts.of_face[f]] += surface.areas[f];
        uv_area[charts.of_face[f]] += texcoord_area(of, f);
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
    const std::vector<double> areas = face_areas(surface.mesh);
    const Vec3f axis = normalized(up);
    return {axis, positive(ahead_of(surface, areas, axis))};
}

TangentFrame frame_at(Vec3f normal, const Upright& upright)
{
    constexpr float level = 0.70710678F;
    const Vec3f top = std::abs(dot(normal, upright.up)) > level ? upright.ahead : upright.up;
    const Vec3f along = top - normal * dot(top, normal);
    const Vec3f up = dot(along, along) > 1e-12F ? normalized(along) : any_perpendicular(normal);
    return {cross(up, normal), -up, normal};
}

}  // namespace fresco::synthesize
