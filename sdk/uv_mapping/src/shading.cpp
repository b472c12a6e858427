#include <fresco/uv_mapping/cracks.h>
#include <fresco/uv_mapping/into_camera.h>
#include <fresco/uv_mapping/shading.h>

#include <algorithm>
#include <cmath>

namespace fresco
{

PixelCounts& PixelCounts::operator+=(const PixelCounts& other)
{
    valid += other.valid;
    back_face += other.back_face;
    too_near += other.too_near;
    crack += other.crack;
    nothing += other.nothing;
    return *this;
}

FaceShader::FaceShader(const Mesh& mesh) : mesh_(mesh)
{
    const auto normals = vertex_normals(mesh);
    vertices_.reserve(normals.size());
    for (std::size_t v = 0; v < normals.size(); ++v)
        vertices_.push_back({mesh.positions[v], normals[v]});
}

/// A face seen from a camera's place: what takes a ray's direction to everything that the map holds. Corners a, b, c; the ray
/// along d meets the face's plane where the weights of b and c are (d.weigh_b)/(d.normal) and (d.weigh_c)/(d.normal): Cramer's
/// rule as in Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997).
struct FaceShader::Plane
{
    Vec3d normal;
    Vec3d weigh_b;
    Vec3d weigh_c;
    std::array<double, 3> depth;  ///< Of a, and from a to b and to c.
    std::array<Vec2d, 3> uv;      ///< The same.
    std::array<Vec3d, 3> smooth;  ///< The vertices' normals, the same.
};

FaceShader::Plane FaceShader::plane_of(std::uint32_t face, Vec3d origin, Vec3d depth_axis) const
{
    const Triangle& t = mesh_.triangles[face];
    const Vertex& va = vertices_[t[0]];
    const Vertex& vb = vertices_[t[1]];
    const Vertex& vc = vertices_[t[2]];
    const Vec3d position = vec_cast<double>(va.position);
    const Vec3d a = position - origin;
    const Vec3d to_b = vec_cast<double>(vb.position) - position;
    const Vec3d to_c = vec_cast<double>(vc.position) - position;
    const Vec2f* texcoords = &mesh_.texcoords[3 * std::size_t{face}];
    const auto wide = [](Vec2f v) { return Vec2d{double{v.x}, double{v.y}}; };
    const Vec2d uv = wide(texcoords[0]);
    const Vec3d smooth = vec_cast<double>(va.normal);
    return {cross(to_b, to_c),
            cross(to_c, a),
            cross(a, to_b),
            {dot(a, depth_axis), dot(to_b, depth_axis), dot(to_c, depth_axis)},
            {uv, wide(texcoords[1]) - uv, wide(texcoords[2]) - uv},
            {smooth, vec_cast<double>(vb.normal) - smooth, vec_cast<double>(vc.normal) - smooth}};
}

namespace
{

/// Weights of b and c that lie inside the face.
void clamp_inside(double& b, double& c)
{
    if (!std::isfinite(b) || !std::isfinite(c))
    {
        // The ray runs along the plane.
        b = c = 1.0 / 3;
        return;
    }
    const double a = std::max(1 - b - c, 0.0);
    b = std::max(b, 0.0);
    c = std::max(c, 0.0);
    const double sum = a + b + c;
    b /= sum;
    c /= sum;
}

void clear_pixel(UvMap& map, std::size_t i)
{
    map.uv.values[2 * i] = map.uv.values[2 * i + 1] = 0;
    map.depth.values[i] = 0;
    map.cosine.values[i] = 0;
    map.valid.values[i] = 0;
}

}  // namespace

Sight FaceShader::shade_pixel(const Plane& plane, Vec3d ray, UvMap& map, std::size_t i, float& met)
{
    const double against = dot(plane.normal, ray);
    const double whole = 1 / against;
    double b = dot(plane.weigh_b, ray) * whole;
    double c = dot(plane.weigh_c, ray) * whole;
    if (!(b >= 0 && c >= 0 && b + c <= 1))
        clamp_inside(b, c);
    const double depth = plane.depth[0] + b * plane.depth[1] + c * plane.depth[2];
    met = static_cast<float>(depth);
    const Sight seen = sight(against < 0, depth);
    if (seen != Sight::surface)
        return seen;
    const Vec2d uv = plane.uv[0] + plane.uv[1] * b + plane.uv[2] * c;
    const Vec3d smooth = plane.smooth[0] + plane.smooth[1] * b + plane.smooth[2] * c;
    const double lengths = std::sqrt(dot(smooth, smooth) * dot(ray, ray));
    const double cosine = lengths > 0 ? -dot(smooth, ray) / lengths : 0.0;
    map.uv.values[2 * i] = static_cast<float>(uv.x);
    map.uv.values[2 * i + 1] = static_cast<float>(uv.y);
    map.depth.values[i] = met;
    map.cosine.values[i] = static_cast<float>(std::clamp(cosine, 0.0, 1.0));
    map.valid.values[i] = 1;
    return seen;
}

PixelCounts FaceShader::shade(const Camera& camera, const FaceMap& faces, int first_row, int end_row, UvMap& map,
                              RasterF& met) const
{
    const Vec3d origin = camera.world_from_camera.translation;
    const Vec3d depth_axis = IntoCamera(camera.world_from_camera).depth_axis();
    const Vec3d across = camera.world_from_camera.direction({1 / camera.intrinsics.fx, 0, 0});
    std::array<std::int64_t, 4> seen{};
    Plane plane{};
    std::uint32_t current = no_face;
    for (int y = first_row; y < end_row; ++y)
    {
        const Vec3d row = camera.ray(0.5, y + 0.5);
        std::size_t i = faces.index(0, y);
        for (int x = 0; x < faces.width; ++x, ++i)
        {
            const std::uint32_t face = faces.values[i];
            Sight end = Sight::nothing;
            met.values[i] = std::numeric_limits<float>::infinity();
            if (face != no_face)
            {
                if (face != current)
                    plane = plane_of(current = face, origin, depth_axis);
                end = shade_pixel(plane, row + across * static_cast<double>(x), map, i, met.values[i]);
            }
            if (end != Sight::surface)
                clear_pixel(map, i);
            ++seen[static_cast<std::size_t>(end)];
        }
    }
    const auto count = [&](Sight end) { return seen[static_cast<std::size_t>(end)]; };
    return {count(Sight::surface), count(Sight::back_face), count(Sight::too_near), 0, count(Sight::nothing)};
}

std::int64_t FaceShader::close_cracks(const RasterF& met, int first_row, int end_row, UvMap& map)
{
    std::int64_t closed = 0;
    for (int y = first_row; y < end_row; ++y)
        for (int x = 0; x < met.width; ++x)
            if (seen_through_crack(met, x, y) && map.valid.at(x, y) != 0)
            {
                clear_pixel(map, map.valid.index(x, y));
                ++closed;
            }
    return closed;
}

}  // namespace fresco
