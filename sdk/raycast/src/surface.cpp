#include <fresco/raycast/surface.h>

namespace fresco::raycast
{

Sight sight(const Hit& hit)
{
    if (!hit.found())
        return Sight::nothing;
    if (!hit.front)
        return Sight::back_face;
    return hit.distance < nearest_surface_m ? Sight::too_near : Sight::surface;
}

std::array<Vec3d, 3> corners(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    return {vec_cast<double>(mesh.positions[t[0]]), vec_cast<double>(mesh.positions[t[1]]),
            vec_cast<double>(mesh.positions[t[2]])};
}

Vec2d texcoord(const Mesh& mesh, std::uint32_t triangle, const std::array<double, 3>& weights)
{
    Vec2d uv;
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
        const Vec2f c = mesh.texcoords[3 * std::size_t{triangle} + corner];
        uv = uv + Vec2d{c.x, c.y} * weights[corner];
    }
    return uv;
}

Vec2d texcoord(const Mesh& mesh, const Hit& hit)
{
    return texcoord(mesh, hit.triangle, hit.weights);
}

Vec3d normal(const Mesh& mesh, std::span<const Vec3f> vertex_normals, const Hit& hit)
{
    const Triangle& t = mesh.triangles[hit.triangle];
    Vec3d sum;
    for (std::size_t corner = 0; corner < 3; ++corner)
        sum += vec_cast<double>(vertex_normals[t[corner]]) * hit.weights[corner];
    return normalized(sum);
}

}  // namespace fresco::raycast
