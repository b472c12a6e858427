#include <fresco/raycast/surface.h>

#include <algorithm>

namespace fresco::raycast
{

Sight sight(const Hit& hit)
{
    if (!hit.found())
        return Sight::nothing;
    return fresco::sight(hit.front, hit.distance);
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

double texels_per_pixel(const Mesh& mesh, std::uint32_t triangle, Vec2d uv, const Camera& camera, double x, double y, int width,
                        int height)
{
    const auto plane = corners(mesh, triangle);
    const auto texels_to = [&](double px, double py)
    {
        double distance = 0;
        std::array<double, 3> weights{};
        if (!meet_plane(plane, camera.world_from_camera.translation, camera.ray(px, py), distance, weights) || distance <= 0)
            return 0.0;
        const Vec2d step = texcoord(mesh, triangle, weights) - uv;
        return length(Vec2d{step.x * width, step.y * height});
    };
    return std::max(texels_to(x + 1, y), texels_to(x, y + 1));
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
