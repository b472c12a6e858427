#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/testing_scenes.h>

#include <optional>
#include <vector>

/// Red discs on planes, seen by a camera; a slow, exact renderer.
namespace painted_discs
{

struct Plane
{
    fresco::Vec3d point;
    fresco::Vec3d normal;
};

struct Disc
{
    std::size_t plane = 0;
    fresco::Vec3d center;  ///< On the plane.
    double radius = 0;     ///< Meters.
    fresco::Rgb8 color{230, 20, 30};
};

struct Scene
{
    std::vector<Plane> planes;
    std::vector<Disc> discs;
};

/// The first plane that the ray meets, as distance and index.
inline std::optional<std::pair<double, std::size_t>> first_plane(const Scene& scene, const fresco::Camera& camera, double x,
                                                                 double y)
{
    std::optional<std::pair<double, std::size_t>> best;
    const fresco::Vec3d origin = camera.world_from_camera.translation;
    const fresco::Vec3d ray = camera.ray(x, y);
    for (std::size_t i = 0; i < scene.planes.size(); ++i)
    {
        const double t = dot(scene.planes[i].point - origin, scene.planes[i].normal) / dot(ray, scene.planes[i].normal);
        if (t > 0 && (!best || t < best->first))
            best = {t, i};
    }
    return best;
}

/// Antialiased by 4 x 4 rays per pixel; the rest is white.
inline fresco::Raster8 render(const Scene& scene, const fresco::Camera& camera)
{
    constexpr int side = 4;
    fresco::Raster8 picture(camera.intrinsics.width, camera.intrinsics.height, 3);
    const auto color_at = [&](double x, double y) -> fresco::Rgb8
    {
        const auto hit = first_plane(scene, camera, x, y);
        if (hit)
        {
            const fresco::Vec3d p = camera.world_from_camera.translation + camera.ray(x, y) * hit->first;
            for (const Disc& disc : scene.discs)
                if (disc.plane == hit->second && length(p - disc.center) <= disc.radius)
                    return disc.color;
        }
        return {255, 255, 255};
    };
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
        {
            int sum[3] = {0, 0, 0};
            for (int s = 0; s < side * side; ++s)
            {
                const fresco::Rgb8 color = color_at(x + (s % side + 0.5) / side, y + (s / side + 0.5) / side);
                for (std::size_t c = 0; c < 3; ++c)
                    sum[c] += color[c];
            }
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = static_cast<std::uint8_t>((sum[c] + side * side / 2) / (side * side));
        }
    return picture;
}

using fresco::testing::camera;

}  // namespace painted_discs
