#pragma once

#include "pair_figures.h"

#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <cmath>

/// A wall z = 2 m over x, y in [-3, 3] m that faces the cameras, which look along z: a pixel is 2 cm at 100 px focal length.
namespace wall_scene
{

inline fresco::TexturedMesh wall(fresco::Raster8 picture)
{
    fresco::TexturedMesh textured;
    textured.mesh = fresco::testing::wall(3);
    textured.image = fresco::Image(std::move(picture));
    return textured;
}

/// Moved by (x, y) px of the wall's picture in it, and forwards by z meters.
inline fresco::Camera camera(int width, int height, double x_px, double y_px, double z = 0)
{
    return fresco::testing::camera(width, height, 100, {x_px * 0.02, y_px * 0.02, z});
}

/// What a camera that looks along z sees of the wall, without casting.
inline ViewSurface surface(const fresco::Camera& camera)
{
    const int width = camera.intrinsics.width;
    const int height = camera.intrinsics.height;
    const auto depth = static_cast<float>(2 - camera.world_from_camera.translation.z);
    ViewSurface view{camera, fresco::RasterF(width, height, 1, depth), fresco::Raster8(width, height),
                     fresco::Raster<std::uint32_t>(width, height)};
    find_inner_pixels(view);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const fresco::Vec3d p = view.point(x, y);
            view.triangles.at(x, y) = p.x > p.y ? 0 : 1;  // the diagonal x = y parts them
        }
    return view;
}

using fresco::testing::picture;

/// The wall's picture seen at pixel centers, bilinear, without mip-maps.
inline fresco::Raster8 render(const fresco::TexturedMesh& textured, const fresco::Camera& camera)
{
    const fresco::rendering::MipMaps maps(textured.image.pixels, fresco::rendering::TextureFilter::bilinear);
    const double depth = 2 - camera.world_from_camera.translation.z;
    return picture(camera.intrinsics.width, camera.intrinsics.height,
                   [&](int x, int y, int c)
                   {
                       const fresco::Vec3d p = camera.world_from_camera.translation + camera.ray(x + 0.5, y + 0.5) * depth;
                       const fresco::Vec3d color = maps.sample({(p.x + 3) / 6, 1 - (p.y + 3) / 6}, 0);
                       return c == 0 ? color.x : c == 1 ? color.y : color.z;
                   });
}

}  // namespace wall_scene
