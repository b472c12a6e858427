#pragma once

#include <fresco/mesh.h>
#include <fresco/texture.h>

/// A wall of 2 m x 1 m in two square charts beside each other on the wall but apart in the atlas: the left half of the wall in
/// u 0.1..0.4, the right half in u 0.6..0.9, both in v 0.1..0.4, the right one turned by 180 degrees.
inline fresco::Mesh two_chart_wall()
{
    fresco::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
    mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
    const fresco::Vec2f a{0.1F, 0.1F}, b{0.4F, 0.1F}, c{0.4F, 0.4F}, d{0.1F, 0.4F};
    const fresco::Vec2f e{0.9F, 0.4F}, f{0.6F, 0.4F}, g{0.6F, 0.1F}, h{0.9F, 0.1F};
    mesh.texcoords = {a, b, c, a, c, d, e, f, g, e, g, h};
    return mesh;
}

/// One layer of one color, nothing seen.
inline fresco::Texture blank_texture(int size, float value)
{
    fresco::Texture texture;
    texture.layers.emplace_back(size, size, 3, value);
    texture.seen = fresco::Raster8(size, size);
    return texture;
}

/// Paints and marks as seen the texels whose centers are in a rectangle of uv.
inline void see(fresco::Texture& texture, fresco::Vec2f low, fresco::Vec2f high, fresco::Vec3f rgb)
{
    fresco::RasterF& layer = texture.layers.front();
    for (int y = 0; y < layer.height; ++y)
        for (int x = 0; x < layer.width; ++x)
        {
            const float u = (static_cast<float>(x) + 0.5F) / static_cast<float>(layer.width);
            const float v = 1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(layer.height);
            if (u < low.x || u > high.x || v < low.y || v > high.y)
                continue;
            layer.at(x, y, 0) = rgb.x;
            layer.at(x, y, 1) = rgb.y;
            layer.at(x, y, 2) = rgb.z;
            texture.seen.at(x, y) = 1;
        }
}
