#include "plain_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace plain
{

namespace
{
Point cross(const Point& a, const Point& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Point& a, const Point& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Point to_camera(const View& view, const Point& world)
{
    const auto& m = view.world_from_camera;
    const Point from_eye{world[0] - m[3], world[1] - m[7], world[2] - m[11]};
    return {dot({m[0], m[4], m[8]}, from_eye), dot({m[1], m[5], m[9]}, from_eye), dot({m[2], m[6], m[10]}, from_eye)};
}

/// A texture lookup as OpenGL defines it: linear, clamped to the edge.
std::array<double, 3> lookup(const Picture& picture, double u, double v, const Wrong& wrong)
{
    if (wrong.flipped_v)
        v = 1 - v;
    const double shift = wrong.half_texel ? 0 : 0.5;
    const double x = u * picture.width - shift;
    const double y = v * picture.height - shift;
    const double left = std::floor(x);
    const double top = std::floor(y);
    std::array<double, 3> result{};
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx)
        {
            const int tx = std::clamp(static_cast<int>(left) + dx, 0, picture.width - 1);
            const int ty = std::clamp(static_cast<int>(top) + dy, 0, picture.height - 1);
            const double share = (dx ? x - left : 1 - x + left) * (dy ? y - top : 1 - y + top);
            for (std::size_t c = 0; c < 3; ++c)
                result[c] += share * picture.rgb[3 * static_cast<std::size_t>(ty * picture.width + tx) + c];
        }
    return result;
}

/// A triangle in camera space; `rows[i]` dotted with a pixel's direction is corner i's weight times the triangle's volume.
struct Prepared
{
    const std::array<Corner, 3>* corners;
    std::array<Point, 3> rows;
    double volume;
};

Prepared prepare(const View& view, const std::array<Corner, 3>& corners)
{
    const Point a = to_camera(view, corners[0].position);
    const Point b = to_camera(view, corners[1].position);
    const Point c = to_camera(view, corners[2].position);
    return {&corners, {cross(b, c), cross(c, a), cross(a, b)}, dot(a, cross(b, c))};
}
}  // namespace

std::vector<Pixel> render(const Model& model, const Picture& picture, const View& view, const Wrong& wrong)
{
    std::vector<Prepared> prepared;
    for (const auto& triangle : model.triangles)
        prepared.push_back(prepare(view, triangle));

    std::vector<Pixel> pixels;
    for (int row = 0; row < view.height; ++row)
        for (int column = 0; column < view.width; ++column)
        {
            const double x = wrong.mirrored_axis ? view.width - (column + 0.5) : column + 0.5;
            const Point direction{(x - view.cx) / view.fx, (row + 0.5 - view.cy) / view.fy, 1};
            Pixel pixel;
            double nearest = std::numeric_limits<double>::infinity();
            for (const Prepared& t : prepared)
            {
                // direction = w0 a + w1 b + w2 c; the point direction * depth lies on the triangle for depth = 1 / (w0 + w1 +
                // w2).
                const Point w{dot(t.rows[0], direction) / t.volume, dot(t.rows[1], direction) / t.volume,
                              dot(t.rows[2], direction) / t.volume};
                const double sum = w[0] + w[1] + w[2];
                if (t.volume == 0 || w[0] < 0 || w[1] < 0 || w[2] < 0 || 1 / sum >= nearest)
                    continue;
                nearest = 1 / sum;
                // Corners that run counter-clockwise around the direction they are seen in have a negative volume.
                pixel.found = t.volume < 0;
                double u = 0;
                double v = 0;
                pixel.position = {};
                for (std::size_t i = 0; i < 3; ++i)
                {
                    const Corner& corner = (*t.corners)[i];
                    u += corner.u * w[i] / sum;
                    v += corner.v * w[i] / sum;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        pixel.position[axis] += corner.position[axis] * w[i] / sum;
                }
                pixel.rgb = lookup(picture, u, v, wrong);
            }
            pixels.push_back(pixel);
        }
    return pixels;
}

}  // namespace plain
