#pragma once

#include <fresco/image.h>
#include <fresco/images/lab.h>
#include <fresco/numerics/noise.h>
#include <fresco/random.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

/// Pictures made for the tests: a painting, a photograph, and what goes wrong between the two.
namespace pictures
{

inline fresco::Vec3f color_at(const fresco::Raster8& rgb, int x, int y)
{
    const auto share = [&](int c) { return static_cast<float>(rgb.at(x, y, c)) / 255; };
    return {share(0), share(1), share(2)};
}

inline void set_color(fresco::Raster8& rgb, int x, int y, fresco::Vec3f color)
{
    const std::array<float, 3> values{color.x, color.y, color.z};
    for (int c = 0; c < 3; ++c)
        rgb.at(x, y, c) =
            static_cast<std::uint8_t>(std::lround(255 * std::clamp(values[static_cast<std::size_t>(c)], 0.0F, 1.0F)));
}

/// Calls visit(x, y, place on the surface) for every texel of a `size` x `size` texture that a face touches.
template <class Visit>
void each_texel(const fresco::Mesh& mesh, int size, const Visit& visit)
{
    using namespace fresco::texturing;
    const TexelFaces faces = find_texel_faces(mesh, find_charts(mesh), size, fresco::Progress());
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            if (const auto texel = static_cast<std::size_t>(y * size + x); faces.covered(texel))
                visit(x, y, texel_position(mesh, faces, texel));
}

/// A new picture whose colors come from those of another by place.
template <class F>
fresco::Raster8 changed(const fresco::Raster8& rgb, const F& color)
{
    fresco::Raster8 result(rgb.width, rgb.height, 3);
    for (int y = 0; y < rgb.height; ++y)
        for (int x = 0; x < rgb.width; ++x)
            set_color(result, x, y, color(x, y));
    return result;
}

/// Smooth values in 0..1 that change over about `period` pixels.
inline float smooth_noise(float x, float y, float period, std::uint32_t seed)
{
    const float gx = x / period + 100;
    const float gy = y / period + 100;
    const auto ix = static_cast<std::uint32_t>(gx);
    const auto iy = static_cast<std::uint32_t>(gy);
    const auto corner = [&](std::uint32_t dx, std::uint32_t dy)
    { return fresco::noise::unit(fresco::noise::hash(ix + dx, iy + dy), seed); };
    const float sx = fresco::noise::smooth_step(0, 1, gx - static_cast<float>(ix));
    const float sy = fresco::noise::smooth_step(0, 1, gy - static_cast<float>(iy));
    const float top = corner(0, 0) * (1 - sx) + corner(1, 0) * sx;
    const float bottom = corner(0, 1) * (1 - sx) + corner(1, 1) * sx;
    return top * (1 - sy) + bottom * sy;
}

/// Strokes of 5 x 40 px that follow a slowly turning direction, in blues and yellows with bristles.
inline fresco::Raster8 painting(int width, int height, std::uint64_t seed)
{
    fresco::Raster8 canvas(width, height, 3, 90);
    fresco::Random random(seed);
    const auto field = static_cast<std::uint32_t>(seed);
    for (int stroke = 0; stroke < width * height / 12; ++stroke)
    {
        const auto x = static_cast<float>(random.uniform() * width);
        const auto y = static_cast<float>(random.uniform() * height);
        const float angle = 6 * smooth_noise(x, y, 90, field);
        const float yellow =
            std::clamp(4 * smooth_noise(x, y, 60, field + 1) - 1.5F + 0.4F * static_cast<float>(random.normal()), 0.0F, 1.0F);
        const auto light = static_cast<float>(0.55 + 0.45 * random.uniform());
        const fresco::Vec3f paint = fresco::Vec3f{0.15F, 0.25F, 0.6F} * (1 - yellow) + fresco::Vec3f{0.95F, 0.8F, 0.25F} * yellow;
        for (int i = -28; i <= 28; ++i)
            for (int j = -4; j <= 4; ++j)
            {
                const float along = 0.7F * static_cast<float>(i);
                const float across = 0.7F * static_cast<float>(j);
                const int px = static_cast<int>(x + std::cos(angle) * along - std::sin(angle) * across);
                const int py = static_cast<int>(y + std::sin(angle) * along + std::cos(angle) * across);
                const float bristle = 0.85F + 0.15F * std::sin(3 * across);
                if (px >= 0 && py >= 0 && px < width && py < height)
                    set_color(canvas, px, py, paint * (light * bristle));
            }
    }
    return canvas;
}

/// Shaded walls and boxes: smooth but for their outlines, with a trace of the sensor's noise.
inline fresco::Raster8 photograph(int width, int height, std::uint64_t seed)
{
    fresco::Random random(seed);
    fresco::Raster8 picture(width, height, 3);
    struct Box
    {
        int x, y, width, height;
        fresco::Vec3f color;
    };
    std::array<Box, 9> boxes;
    const auto below = [&](int count) { return static_cast<int>(random.below(count)); };
    const auto unit = [&] { return static_cast<float>(random.uniform()); };
    for (Box& box : boxes)
        box = {below(width) - width / 8,
               below(height) - height / 8,
               width / 6 + below(width / 4),
               height / 6 + below(height / 4),
               {0.2F + 0.6F * unit(), 0.2F + 0.6F * unit(), 0.2F + 0.6F * unit()}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            fresco::Vec3f color{0.7F, 0.65F, 0.6F};
            for (const Box& box : boxes)
                if (x >= box.x && y >= box.y && x < box.x + box.width && y < box.y + box.height)
                    color = box.color;
            const float shade = 0.7F + 0.3F * smooth_noise(static_cast<float>(x), static_cast<float>(y), 80, 5);
            const auto grain = static_cast<float>(0.004 * random.normal());
            set_color(picture, x, y, color * shade + fresco::Vec3f{grain, grain, grain});
        }
    return picture;
}

/// With the mean and covariance of another picture's colors.
inline fresco::Raster8 recolored(const fresco::Raster8& rgb, const fresco::Raster8& style)
{
    const auto moments = [](const fresco::Raster8& picture)
    {
        fresco::ColorMoments result;
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x)
                result.add(fresco::vec_cast<double>(color_at(picture, x, y)));
        return result;
    };
    const fresco::ColorMap map = fresco::monge_kantorovich(moments(rgb), moments(style));
    return changed(rgb,
                   [&](int x, int y) { return fresco::vec_cast<float>(map(fresco::vec_cast<double>(color_at(rgb, x, y)))); });
}

/// Noise on L* or on a* and b*, in their units, from pixel to pixel.
inline fresco::Raster8 noisy(const fresco::Raster8& rgb, double luma, double chroma)
{
    fresco::Random random(3);
    return changed(rgb,
                   [&](int x, int y)
                   {
                       fresco::Vec3f lab = fresco::lab_from_rgb(color_at(rgb, x, y));
                       lab.x += static_cast<float>(luma * random.normal());
                       lab.y += static_cast<float>(chroma * random.normal());
                       lab.z += static_cast<float>(chroma * random.normal());
                       return fresco::rgb_from_lab(lab);
                   });
}

/// 4 channels, covered but for a disc at the middle.
inline fresco::Raster8 with_hole(const fresco::Raster8& rgb, int radius_px)
{
    fresco::Raster8 result(rgb.width, rgb.height, 4);
    for (int y = 0; y < rgb.height; ++y)
        for (int x = 0; x < rgb.width; ++x)
            if (const int dx = x - rgb.width / 2, dy = y - rgb.height / 2; dx * dx + dy * dy > radius_px * radius_px)
            {
                for (int c = 0; c < 3; ++c)
                    result.at(x, y, c) = rgb.at(x, y, c);
                result.at(x, y, 3) = 255;
            }
    return result;
}

}  // namespace pictures
