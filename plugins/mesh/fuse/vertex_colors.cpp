#include "vertex_colors.h"

#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

using namespace fresco;

namespace fuse
{
namespace
{

constexpr double least_facing = 0.2;

bool is_inside(Vec3d seen, const Intrinsics& k)
{
    return seen.z > 0 && seen.x >= 0 && seen.y >= 0 && seen.x < k.width && seen.y < k.height;
}

/// Bilinear, pixel centers at +0.5, clamped at the border.
std::array<float, 3> color_at(const Raster8& picture, double u, double v)
{
    const auto column = numerics::between<double>(u - 0.5, picture.width);
    const auto row = numerics::between<double>(v - 0.5, picture.height);
    std::array<float, 3> color{};
    for (int c = 0; c < 3; ++c)
        color[static_cast<std::size_t>(c)] =
            static_cast<float>(numerics::bilinear(column, row, [&](int x, int y) { return picture.at(x, y, c); }));
    return color;
}

/// Vertices without a color take the mean of their neighbors', from those nearest to a color on.
template <class Sum>
void spread(const std::vector<Triangle>& triangles, std::vector<Sum>& sums)
{
    for (bool changed = true; changed;)
    {
        changed = false;
        std::vector<std::pair<std::uint32_t, Sum>> added;
        for (const Triangle& triangle : triangles)
            for (const std::uint32_t to : triangle)
                for (const std::uint32_t from : triangle)
                    if (sums[to][3] == 0 && sums[from][3] > 0)
                        added.emplace_back(to, sums[from]);
        for (const auto& [to, sum] : added)
        {
            changed = true;
            for (std::size_t c = 0; c < sum.size(); ++c)
                sums[to][c] += sum[c] / sum[3];
        }
    }
}

}  // namespace

VertexColors::VertexColors(const Mesh& mesh, double tolerance_m)
    : mesh_(mesh), normals_(vertex_normals(mesh)), tolerance_m_(tolerance_m), sums_(mesh.positions.size(), Sum{})
{
}

void VertexColors::add(const ColorView& view, const RigidTransform& camera_from_world, std::size_t vertex)
{
    const Vec3d position = vec_cast<double>(mesh_.positions[vertex]);
    const Vec3d local = camera_from_world.point(position);
    if (!(local.z > 0))
        return;
    const Intrinsics& k = view.depth_camera.intrinsics;
    const Vec3d seen{k.fx * local.x / local.z + k.cx, k.fy * local.y / local.z + k.cy, local.z};
    if (!is_inside(seen, k))
        return;
    const double measured = double{view.depth.at(static_cast<int>(seen.x), static_cast<int>(seen.y))};
    if (!(measured > 0) || std::abs(measured - local.z) > tolerance_m_)
        return;
    const Vec3d toward = normalized(view.depth_camera.world_from_camera.translation - position);
    const double cosine = dot(toward, vec_cast<double>(normals_[vertex]));
    if (!(cosine >= least_facing))
        return;
    const Vec3d pixel = view.color_camera.project(position);
    if (!is_inside(pixel, view.color_camera.intrinsics))
        return;
    const auto weight = static_cast<float>(cosine / (local.z * local.z));
    const std::array<float, 3> color = color_at(view.picture, pixel.x, pixel.y);
    Sum& sum = sums_[vertex];
    for (std::size_t c = 0; c < color.size(); ++c)
        sum[c] += weight * color[c];
    sum[3] += weight;
}

void VertexColors::add(std::span<const ColorView> views, const Progress& progress)
{
    std::vector<RigidTransform> cameras_from_world;
    for (const ColorView& view : views)
        cameras_from_world.push_back(view.depth_camera.world_from_camera.inverse());
    parallel_for(sums_.size(), 4096, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t i = 0; i < views.size(); ++i)
                         for (std::size_t vertex = begin; vertex < end; ++vertex)
                             add(views[i], cameras_from_world[i], vertex);
                 });
}

std::vector<Rgb8> VertexColors::colors() const
{
    constexpr Rgb8 gray{128, 128, 128};
    std::vector<Sum> sums = sums_;
    spread(mesh_.triangles, sums);
    std::vector<Rgb8> colors;
    for (const Sum& sum : sums)
    {
        const auto value = [&](std::size_t c) { return static_cast<std::uint8_t>(std::lround(sum[c] / sum[3])); };
        colors.push_back(sum[3] > 0 ? Rgb8{value(0), value(1), value(2)} : gray);
    }
    return colors;
}

}  // namespace fuse
