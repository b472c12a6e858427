#include "plain_uv_maps.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace bench
{
namespace
{

using fresco::Vec3d;

/// Nearer than this the pixel is not valid (METHOD section 1).
constexpr double nearest_m = 0.05;

struct Meeting
{
    std::size_t face = 0;
    double depth = std::numeric_limits<double>::infinity();
    double second = 0;  ///< Weight of the second corner, …
    double third = 0;   ///< … and of the third.
    bool front = false;
};

/// A face as Möller and Trumbore's test wants it.
struct Sides
{
    Vec3d corner;
    Vec3d to_second;
    Vec3d to_third;
};

std::vector<Sides> sides_of(const fresco::Mesh& mesh)
{
    std::vector<Sides> result;
    for (const auto& t : mesh.triangles)
    {
        const auto a = fresco::vec_cast<double>(mesh.positions[t[0]]);
        result.push_back(
            {a, fresco::vec_cast<double>(mesh.positions[t[1]]) - a, fresco::vec_cast<double>(mesh.positions[t[2]]) - a});
    }
    return result;
}

Meeting first_meeting(const std::vector<Sides>& faces, Vec3d origin, Vec3d ray)
{
    Meeting best;
    for (std::size_t f = 0; f < faces.size(); ++f)
    {
        const auto& face = faces[f];
        const Vec3d p = cross(ray, face.to_third);
        const double volume = dot(face.to_second, p);
        if (volume == 0)
            continue;
        const Vec3d from_corner = origin - face.corner;
        const double second = dot(from_corner, p) / volume;
        if (!(second >= 0 && second <= 1))
            continue;
        const Vec3d q = cross(from_corner, face.to_second);
        const double third = dot(ray, q) / volume;
        if (!(third >= 0 && second + third <= 1))
            continue;
        const double depth = dot(face.to_third, q) / volume;
        if (depth > 0 && depth < best.depth)
            best = {f, depth, second, third, volume > 0};
    }
    return best;
}

}  // namespace

fresco::UvMap plain_uv_map(const fresco::Mesh& mesh, const fresco::Camera& camera, int height_px)
{
    fresco::Camera scaled = camera;
    scaled.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width_at(height_px), height_px);
    const int width = scaled.intrinsics.width;
    fresco::UvMap map{fresco::RasterF(width, height_px, 2), fresco::RasterF(width, height_px), fresco::RasterF(width, height_px),
                      fresco::Raster8(width, height_px)};
    const auto faces = sides_of(mesh);
    const auto normals = fresco::vertex_normals(mesh);
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
        {
            const Vec3d ray = scaled.ray(x + 0.5, y + 0.5);
            const auto met = first_meeting(faces, scaled.world_from_camera.translation, ray);
            if (met.depth == std::numeric_limits<double>::infinity() || !met.front || met.depth < nearest_m)
                continue;
            const std::array<double, 3> weights{1 - met.second - met.third, met.second, met.third};
            fresco::Vec2d uv;
            Vec3d normal;
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto corner = mesh.texcoords[3 * met.face + k];
                uv = uv + fresco::Vec2d{corner.x, corner.y} * weights[k];
                normal += fresco::vec_cast<double>(normals[mesh.triangles[met.face][k]]) * weights[k];
            }
            map.uv.at(x, y, 0) = static_cast<float>(uv.x);
            map.uv.at(x, y, 1) = static_cast<float>(uv.y);
            map.depth.at(x, y) = static_cast<float>(met.depth);
            map.cosine.at(x, y) = static_cast<float>(std::clamp(-dot(normalized(normal), normalized(ray)), 0.0, 1.0));
            map.valid.at(x, y) = 1;
        }
    return map;
}

}  // namespace bench
