#pragma once

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/random.h>
#include <fresco/texture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

/// \file Scenes whose measures are known by hand, for the tests of plugins in the tree and outside it: walls, boxes and rooms,
/// the cameras that see them, and their pictures. Header-only and without a test framework.

namespace fresco::testing
{

// Meshes

/// Adds `other`. Colors, texcoords and charts are kept where both have them.
inline void append(Mesh& mesh, const Mesh& other)
{
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const bool was_empty = mesh.triangles.empty();
    const auto join = [was_empty](auto& values, const auto& more)
    {
        if (values.empty() != more.empty() && !was_empty)
            values.clear();
        else
            values.insert(values.end(), more.begin(), more.end());
    };
    join(mesh.colors, other.colors);
    join(mesh.texcoords, other.texcoords);
    join(mesh.charts, other.charts);
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const Triangle& t : other.triangles)
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

/// A rectangle from `corner` along `x` and `y` in columns x rows squares; it faces cross(x, y). Vertices by row.
inline Mesh rectangle(Vec3f corner, Vec3f x, Vec3f y, std::uint32_t columns = 1, std::uint32_t rows = 1)
{
    Mesh mesh;
    for (std::uint32_t row = 0; row <= rows; ++row)
        for (std::uint32_t column = 0; column <= columns; ++column)
            mesh.positions.push_back(corner + x * (static_cast<float>(column) / static_cast<float>(columns)) +
                                     y * (static_cast<float>(row) / static_cast<float>(rows)));
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t column = 0; column < columns; ++column)
        {
            const std::uint32_t v = row * (columns + 1) + column;
            mesh.triangles.push_back({v, v + 1, v + columns + 2});
            mesh.triangles.push_back({v, v + columns + 2, v + columns + 1});
        }
    return mesh;
}

/// Sets the texcoord of every corner to uv(position).
template <class F>
void set_texcoords(Mesh& mesh, const F& uv)
{
    mesh.texcoords.clear();
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            mesh.texcoords.push_back(uv(mesh.positions[v]));
}

/// n x n squares over [0,1]², at height(x, y); each is cut from its right end to its upper one.
template <class Height>
Mesh grid(std::uint32_t n, const Height& height)
{
    Mesh mesh = rectangle({}, {1, 0, 0}, {0, 1, 0}, n, n);
    for (Vec3f& p : mesh.positions)
        p.z = height(p.x, p.y);
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 2)
    {
        const auto [v, right, across] = mesh.triangles[t];
        const std::uint32_t above = mesh.triangles[t + 1][2];
        mesh.triangles[t] = {v, right, above};
        mesh.triangles[t + 1] = {right, across, above};
    }
    return mesh;
}

/// A wall over x, y in [-half_m, half_m] that faces cameras at the origin which look along z. It fills the atlas; uv runs with x
/// and against y, as in a picture of the wall.
inline Mesh wall(float half_m = 2, float z_m = 2)
{
    Mesh mesh;
    mesh.positions = {{-half_m, -half_m, z_m}, {half_m, -half_m, z_m}, {half_m, half_m, z_m}, {-half_m, half_m, z_m}};
    mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
    mesh.texcoords = {{0, 1}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}};
    return mesh;
}

/// A wall of 2 m x 1 m in two square charts beside each other on the wall but apart in the atlas: the left half of the wall in
/// u 0.1..0.4, the right half in u 0.6..0.9, both in v 0.1..0.4, the right one turned by 180 degrees.
inline Mesh two_chart_wall()
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
    mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
    const Vec2f a{0.1F, 0.1F}, b{0.4F, 0.1F}, c{0.4F, 0.4F}, d{0.1F, 0.4F};
    const Vec2f e{0.9F, 0.4F}, f{0.6F, 0.4F}, g{0.6F, 0.1F}, h{0.9F, 0.1F};
    mesh.texcoords = {a, b, c, a, c, d, e, f, g, e, g, h};
    return mesh;
}

/// A closed box of 12 faces and 8 vertices, seen from outside. Vertex i lies at low where a bit of i is 0: x 1, y 2, z 4.
inline Mesh box(Vec3f low = {0, 0, 0}, Vec3f size = {1, 1, 1})
{
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back(
            {low.x + ((i & 1) != 0 ? size.x : 0), low.y + ((i & 2) != 0 ? size.y : 0), low.z + ((i & 4) != 0 ? size.z : 0)});
    for (const auto& q :
         {std::array<std::uint32_t, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    return mesh;
}

/// A mesh of rectangles, each a chart of its own in the next cell of an atlas of cells x cells. All charts have one scale: a
/// cell is `cell_m` wide without its margin.
class ChartedMesh
{
  public:
    explicit ChartedMesh(int cells = 4, float cell_m = 5, float margin = 0.04F)
        : cells_(static_cast<float>(cells)), cell_m_(cell_m), margin_(margin)
    {
    }

    /// As testing::rectangle; u runs along x, v along y.
    void rectangle(Vec3f corner, Vec3f x, Vec3f y, std::uint32_t columns = 1, std::uint32_t rows = 1)
    {
        Mesh chart = testing::rectangle(corner, x, y, columns, rows);
        const auto column = static_cast<float>(next_ % static_cast<int>(cells_));
        const auto row = static_cast<float>(next_ / static_cast<int>(cells_));
        const float scale = (1 - 2 * margin_) / cells_ / cell_m_;
        set_texcoords(chart,
                      [&](Vec3f p)
                      {
                          const float u = dot(p - corner, normalized(x)) * scale;
                          const float v = dot(p - corner, normalized(y)) * scale;
                          return Vec2f{(column + margin_) / cells_ + u, (row + margin_) / cells_ + v};
                      });
        chart.charts.assign(chart.triangles.size(), static_cast<std::uint32_t>(next_++));
        append(mesh, chart);
    }

    /// The six sides of a box, seen from outside or from inside.
    void box(Vec3f low, Vec3f size, bool from_outside, std::uint32_t squares = 1)
    {
        const Vec3f x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
        const auto side = [&](Vec3f corner, Vec3f a, Vec3f b)
        { from_outside ? rectangle(corner, a, b, squares, squares) : rectangle(corner, b, a, squares, squares); };
        side(low, y, x);
        side(low + z, x, y);
        side(low, x, z);
        side(low + y, z, x);
        side(low, z, y);
        side(low + x, y, z);
    }

    Mesh mesh;

  private:
    float cells_;
    float cell_m_;
    float margin_;
    int next_ = 0;
};

/// The inside of a box from the origin to `size`, z up: floor, ceiling and four walls, a chart each.
inline Mesh room(Vec3f size = {4, 3, 2.5F}, std::uint32_t squares = 1)
{
    ChartedMesh made(3, std::max({size.x, size.y, size.z}));
    made.box({}, size, false, squares);
    return made.mesh;
}

// Textures over a mesh

/// One layer of one color, nothing seen.
inline Texture blank_texture(int size, float value)
{
    Texture texture;
    texture.layers.emplace_back(size, size, 3, value);
    texture.seen = Raster8(size, size);
    return texture;
}

/// Paints and marks as seen the texels whose centers are in a rectangle of uv.
inline void see(Texture& texture, Vec2f low, Vec2f high, Vec3f rgb)
{
    RasterF& layer = texture.layers.front();
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

// Cameras

/// Looks along z from `at` with y down, turned about y by `turn` radians; the center of the picture is the optical axis.
inline Camera camera(int width, int height, double focal_px, Vec3d at = {}, double turn = 0)
{
    Camera result;
    result.intrinsics = {width, height, focal_px, focal_px, width / 2.0, height / 2.0};
    result.world_from_camera.translation = at;
    result.world_from_camera.rotation.m = {std::cos(turn), 0, std::sin(turn), 0, 1, 0, -std::sin(turn), 0, std::cos(turn)};
    return result;
}

/// The pose at `eye` that looks at `target`, in a world with `up`.
inline RigidTransform looking_at(Vec3d eye, Vec3d target, Vec3d up = {0, 0, 1})
{
    const Vec3d forward = normalized(target - eye);
    const Vec3d right = normalized(cross(forward, up));
    const Vec3d down = cross(forward, right);
    return {{{right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z}}, eye};
}

// Pictures

/// A picture from a function of pixel and channel, rounded and held in 0..255.
template <class F>
Raster8 picture(int width, int height, const F& value, int channels = 3)
{
    Raster8 result(width, height, channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c)
                result.at(x, y, c) =
                    static_cast<std::uint8_t>(std::lround(std::clamp(static_cast<double>(value(x, y, c)), 0.0, 255.0)));
    return result;
}

inline Raster8 noise_picture(int width, int height, std::uint64_t seed, int channels = 3)
{
    Random random(seed);
    return picture(
        width, height, [&](int, int, int) { return static_cast<double>(random.below(256)); }, channels);
}

/// Squares of `field` pixels; the one at the upper left is dark.
inline Raster8 checkerboard(int width, int height, int field, std::uint8_t dark = 0, std::uint8_t light = 255)
{
    return picture(width, height, [=](int x, int y, int) { return (x / field + y / field) % 2 == 0 ? dark : light; });
}

// Rays, against every face in turn: slow and obvious

struct RayHit
{
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t triangle = none;
    double distance = std::numeric_limits<double>::infinity();  ///< Distance in lengths of the direction.
    std::array<double, 3> weights{};                            ///< Weights of the triangle's corners.
    bool front = false;                                         ///< The ray meets the side that the face shows.
    bool found() const { return triangle != none; }
};

/// The first face that the ray meets, from either side.
inline RayHit cast(const Mesh& mesh, Vec3d origin, Vec3d direction)
{
    RayHit best;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    {
        const auto at = [&](std::size_t corner) { return vec_cast<double>(mesh.positions[mesh.triangles[t][corner]]); };
        const Vec3d a = at(0), ab = at(1) - a, ac = at(2) - a;
        const Vec3d normal = cross(ab, ac);
        const double slope = dot(normal, direction);
        if (slope == 0)
            continue;
        const double distance = dot(normal, a - origin) / slope;
        const Vec3d p = origin + direction * distance - a;
        const double c = dot(cross(ab, p), normal) / dot(normal, normal);
        const double b = dot(cross(p, ac), normal) / dot(normal, normal);
        if (distance < 0 || distance >= best.distance || b < 0 || c < 0 || b + c > 1)
            continue;
        best = {t, distance, {1 - b - c, b, c}, slope < 0};
    }
    return best;
}

/// Depth in meters along the optical axis at pixel centers; 0 where nothing is seen.
inline RasterF depth_of(const Mesh& mesh, const Camera& camera)
{
    RasterF depth(camera.intrinsics.width, camera.intrinsics.height);
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
        {
            const RayHit hit = cast(mesh, camera.world_from_camera.translation, camera.ray(x + 0.5, y + 0.5));
            depth.at(x, y) = hit.found() ? static_cast<float>(hit.distance) : 0;
        }
    return depth;
}

/// The mesh as `camera` sees it, painted by a function of the point and the channel (0..255); black where nothing is seen.
template <class F>
Raster8 picture_of(const Mesh& mesh, const Camera& camera, const F& paint)
{
    return picture(camera.intrinsics.width, camera.intrinsics.height,
                   [&](int x, int y, int c)
                   {
                       const Vec3d eye = camera.world_from_camera.translation;
                       const Vec3d ray = camera.ray(x + 0.5, y + 0.5);
                       const RayHit hit = cast(mesh, eye, ray);
                       return hit.found() ? static_cast<double>(paint(eye + ray * hit.distance, c)) : 0.0;
                   });
}

// Recordings

/// A frame of sequence "seq-01" whose two cameras are one, without pictures.
inline Frame frame(const std::string& name, const Camera& camera, long number = 0)
{
    Frame result;
    result.sequence = "seq-01";
    result.name = name;
    result.number = number;
    result.color = result.depth = camera;
    return result;
}

/// Writes the color picture to folder/NAME.color.npy and makes it the frame's.
inline void set_color_picture(Frame& frame, const std::filesystem::path& folder, const Raster8& rgb)
{
    frame.color_picture = {folder / (frame.name + ".color.npy"), {}};
    write_npy(frame.color_picture.path, rgb);
}

/// Writes the depths, in meters, to folder/NAME.depth.npy in steps of the frame's depth_unit_m and makes them the frame's.
inline void set_depth_picture(Frame& frame, const std::filesystem::path& folder, const RasterF& depth_m)
{
    frame.depth_picture = {folder / (frame.name + ".depth.npy"), {}};
    Raster16 steps(depth_m.width, depth_m.height);
    std::ranges::transform(depth_m.values, steps.values.begin(),
                           [&](float depth) { return static_cast<std::uint16_t>(std::lround(depth / frame.depth_unit_m)); });
    write_npy(frame.depth_picture.path, steps);
}

}  // namespace fresco::testing
