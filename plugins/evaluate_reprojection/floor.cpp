#include "floor.h"

#include <fresco/parallel.h>
#include <fresco/raycast/surface.h>

#include <algorithm>
#include <cmath>

using namespace fresco;

namespace
{

double level_of(double texels)
{
    return texels > 1 ? std::log2(texels) : 0;
}

/// Where a camera's ray to the point meets the triangle's plane.
raycast::Hit hit_at(const Mesh& mesh, std::uint32_t triangle, Vec3d point, const Camera& camera)
{
    raycast::Hit hit{triangle, true, 0, {1.0 / 3, 1.0 / 3, 1.0 / 3}};  // A triangle without area: any of its points.
    const Vec3d origin = camera.world_from_camera.translation;
    raycast::meet_plane(raycast::corners(mesh, triangle), origin, point - origin, hit.distance, hit.weights);
    return hit;
}

void draw(const ViewSurface& view, const Camera& other, const Raster8& wanted, const SurfacePaint& paint,
          const Progress& progress, Raster8& picture)
{
    const auto draw_rows = [&](std::size_t begin, std::size_t end)
    {
        progress.check_canceled();
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < wanted.width; ++x)
            {
                if (wanted.at(x, y) == 0)
                    continue;
                const Vec3d color = paint.color(view.triangles.at(x, y), view.point(x, y), view.camera, other);
                for (int c = 0; c < 3; ++c)
                    // Rounded as the judged pictures are, so that their rounding is part of the floor.
                    picture.at(x, y, c) = static_cast<std::uint8_t>(std::clamp((c == 0   ? color.x
                                                                                : c == 1 ? color.y
                                                                                         : color.z) +
                                                                                   0.5,
                                                                               0.0, 255.0));
            }
    };
    parallel_for(static_cast<std::size_t>(wanted.height), 8, progress.threads(), draw_rows);
}
}  // namespace

TexturePaint::TexturePaint(const TexturedMesh& textured, const raycast::Lights& lights)
    : mesh_(textured.mesh), picture_(textured.image.pixels, true), lighting_(textured.mesh, lights)
{
}

Vec3d TexturePaint::color(std::uint32_t triangle, Vec3d point, const Camera& a, const Camera& b) const
{
    const raycast::Hit hit = hit_at(mesh_, triangle, point, a);
    const Vec2d uv = raycast::texcoord(mesh_, hit);
    const auto texels = [&](const Camera& camera)
    {
        const Vec3d seen = camera.project(point);
        return raycast::texels_per_pixel(mesh_, triangle, uv, camera, seen.x, seen.y, picture_.width(), picture_.height());
    };
    return picture_.sample(uv, level_of(std::max(texels(a), texels(b)))) * lighting_.at(hit);
}

ProjectedPaint::ProjectedPaint(const Mesh& mesh, const Camera& camera, const Raster8& picture)
    : mesh_(mesh), camera_(camera), picture_(picture, true)
{
}

double ProjectedPaint::pixels_per_pixel(std::uint32_t triangle, Vec3d point, const Camera& other) const
{
    const Vec3d here = camera_.project(point);
    const Vec3d seen = other.project(point);
    const auto plane = raycast::corners(mesh_, triangle);
    const auto pixels_to = [&](double x, double y)
    {
        double distance = 0;
        std::array<double, 3> weights{};
        const Vec3d direction = other.ray(x, y);
        const Vec3d origin = other.world_from_camera.translation;
        if (!raycast::meet_plane(plane, origin, direction, distance, weights) || distance <= 0)
            return 0.0;
        const Vec3d there = camera_.project(origin + direction * distance);
        return there.z > 0 ? length(Vec2d{there.x - here.x, there.y - here.y}) : 0.0;
    };
    return std::max(pixels_to(seen.x + 1, seen.y), pixels_to(seen.x, seen.y + 1));
}

Vec3d ProjectedPaint::color(std::uint32_t triangle, Vec3d point, const Camera& a, const Camera& b) const
{
    const Vec3d here = camera_.project(point);
    const double pixels = std::max(pixels_per_pixel(triangle, point, a), pixels_per_pixel(triangle, point, b));
    return picture_.sample({here.x / picture_.width(), 1 - here.y / picture_.height()}, level_of(pixels));
}

FloorPictures floor_pictures(const ViewSurface& source, const ViewSurface& target, const std::vector<Match>& matches,
                             const SurfacePaint& paint, const Progress& progress)
{
    Raster8 wanted_source(source.depth.width, source.depth.height);
    Raster8 wanted_target(target.depth.width, target.depth.height);
    for (const Match& match : matches)
    {
        wanted_source.at(match.x, match.y) = 1;
        for (const int y : {match.target.y0, match.target.y1})
            for (const int x : {match.target.x0, match.target.x1})
                wanted_target.at(x, y) = 1;
    }
    FloorPictures pictures{Raster8(wanted_source.width, wanted_source.height, 3),
                           Raster8(wanted_target.width, wanted_target.height, 3)};
    draw(source, target.camera, wanted_source, paint, progress, pictures.source);
    draw(target, source.camera, wanted_target, paint, progress, pictures.target);
    return pictures;
}
