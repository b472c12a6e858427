#include "pair_figures.h"

#include <fresco/images/lab.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

using namespace fresco;
using raycast::Hit;

ViewSurface view_surface(const raycast::Scene& scene, const Camera& camera, const Progress& progress)
{
    const int width = camera.intrinsics.width;
    const int height = camera.intrinsics.height;
    ViewSurface view{camera, RasterF(width, height), Raster8(width, height),
                     Raster<std::uint32_t>(width, height, 1, std::uint32_t{Hit::none})};
    parallel_for(static_cast<std::size_t>(height), 8, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<Hit> hits((end - begin) * static_cast<std::size_t>(width));
                     scene.cast_rows(camera, static_cast<int>(begin), static_cast<int>(end), hits);
                     const std::size_t first = begin * static_cast<std::size_t>(width);
                     for (std::size_t i = 0; i < hits.size(); ++i)
                         if (raycast::sight(hits[i]) == raycast::Sight::surface)
                         {
                             view.depth.values[first + i] = static_cast<float>(hits[i].distance);
                             view.triangles.values[first + i] = hits[i].triangle;
                         }
                 });
    find_inner_pixels(view);
    return view;
}

void find_inner_pixels(ViewSurface& view)
{
    const int width = view.depth.width;
    const int height = view.depth.height;
    const auto all_seen = [&](int x, int y)
    {
        for (int ny = std::max(0, y - 1); ny <= std::min(height - 1, y + 1); ++ny)
            for (int nx = std::max(0, x - 1); nx <= std::min(width - 1, x + 1); ++nx)
                if (view.depth.at(nx, ny) <= 0)
                    return false;
        return true;
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            view.inner.at(x, y) = all_seen(x, y) ? 1 : 0;
}

namespace
{

constexpr double snap_px = 1e-6;  // rounding of a projection; equal poses shall meet their own pixels

/// The index of a pixel coordinate: pixel centers at whole numbers.
double index_of(double coordinate)
{
    const double index = coordinate - 0.5;
    const double nearest = std::round(index);
    return std::abs(index - nearest) < snap_px ? nearest : index;
}

std::optional<Lookup> match_of(const ViewSurface& target, Vec3d seen)
{
    const int width = target.depth.width;
    const int height = target.depth.height;
    const double x = index_of(seen.x);
    const double y = index_of(seen.y);
    if (!(x >= 0 && x <= width - 1 && y >= 0 && y <= height - 1))
        return std::nullopt;
    // Pixels without a share are not looked at.
    Lookup lookup{numerics::between(x), numerics::between(y)};
    for (auto* axis : {&lookup.x, &lookup.y})
        if (axis->share == 0)
            axis->second = axis->first;
    const double tolerance = 0.02 * seen.z + 0.01;
    for (const int py : {lookup.y.first, lookup.y.second})
        for (const int px : {lookup.x.first, lookup.x.second})
            if (target.inner.at(px, py) == 0 || !(std::abs(seen.z - double{target.depth.at(px, py)}) <= tolerance))
                return std::nullopt;
    return lookup;
}

}  // namespace

std::vector<Match> covisible(const ViewSurface& source, const ViewSurface& target)
{
    std::vector<Match> matches;
    for (int y = 0; y < source.depth.height; ++y)
        for (int x = 0; x < source.depth.width; ++x)
        {
            if (source.inner.at(x, y) == 0)
                continue;
            const Vec3d seen = target.camera.project(source.point(x, y));
            if (seen.z <= 0)
                continue;
            if (const auto lookup = match_of(target, seen))
                matches.push_back({x, y, *lookup});
        }
    return matches;
}

namespace
{

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

double value_at(const Raster8& picture, const Lookup& at, int channel)
{
    return numerics::bilinear(at.x, at.y, [&](int x, int y) { return picture.at(x, y, channel); });
}

/// A difference on the scale 0..255, on the scale 0..1.
double measured(double difference)
{
    return std::abs(difference) / 255;
}

double gray(const Raster8& picture, int x, int y)
{
    return luma(&picture.at(x, y));
}

}  // namespace

double reprojection_difference(const Raster8& source, const Raster8& target, const std::vector<Match>& matches)
{
    double sum = 0;
    for (const Match& match : matches)
        for (int c = 0; c < 3; ++c)
            sum += measured(source.at(match.x, match.y, c) - value_at(target, match.target, c));
    return matches.empty() ? undefined : sum / static_cast<double>(3 * matches.size());
}

double forward_difference(const Raster8& source, const std::vector<Match>& matches)
{
    double sum = 0;
    std::size_t count = 0;
    for (const Match& match : matches)
        for (int c = 0; c < 3; ++c)
            for (const auto& [x, y] : {std::pair{match.x + 1, match.y}, {match.x, match.y + 1}})
                if (x < source.width && y < source.height)
                {
                    sum += measured(source.at(x, y, c) - source.at(match.x, match.y, c));
                    ++count;
                }
    return count == 0 ? undefined : sum / static_cast<double>(count);
}

double sharpness(const Raster8& source, const std::vector<Match>& matches)
{
    double sum = 0;
    double squares = 0;
    std::size_t count = 0;
    for (const Match& match : matches)
    {
        const int x = match.x;
        const int y = match.y;
        if (x < 1 || y < 1 || x + 1 >= source.width || y + 1 >= source.height)
            continue;
        const double laplacian = gray(source, x - 1, y) + gray(source, x + 1, y) + gray(source, x, y - 1) +
                                 gray(source, x, y + 1) - 4 * gray(source, x, y);
        sum += laplacian;
        squares += laplacian * laplacian;
        ++count;
    }
    if (count == 0)
        return undefined;
    const double mean = sum / static_cast<double>(count);
    return squares / static_cast<double>(count) - mean * mean;
}

namespace
{

double level_of(double texels)
{
    return texels > 1 ? std::log2(texels) : 0;
}

/// Picture of a low-passed surface by a view's camera, RGB; drawn only where `wanted`, black elsewhere.
Raster8 drawn(const ViewSurface& view, const Camera& other, const Raster8& wanted, const SurfacePaint& paint,
              const Progress& progress)
{
    Raster8 picture(wanted.width, wanted.height, 3);
    parallel_items(wanted.height, 8, progress,
                   [&](int y)
                   {
                       for (int x = 0; x < wanted.width; ++x)
                       {
                           if (wanted.at(x, y) == 0)
                               continue;
                           const Vec3d color = paint(view.triangles.at(x, y), view.point(x, y), view.camera, other);
                           const std::array channels{color.x, color.y, color.z};
                           for (int c = 0; c < 3; ++c)
                               // Rounded as the judged pictures are, so that their rounding is part of the floor.
                               picture.at(x, y, c) =
                                   static_cast<std::uint8_t>(std::clamp(channels[static_cast<std::size_t>(c)] + 0.5, 0.0, 255.0));
                       }
                   });
    return picture;
}

/// A picture of the camera's size projected onto the mesh, for pictures without a texture; the mesh must outlive the paint.
SurfacePaint projected_paint(const Mesh& mesh, const Camera& camera, const Raster8& picture)
{
    const auto pixels_per_pixel = [&mesh, camera](std::uint32_t triangle, Vec3d point, const Camera& other)
    {
        const Vec3d here = camera.project(point);
        const Vec3d seen = other.project(point);
        const auto plane = raycast::corners(mesh, triangle);
        const auto pixels_to = [&](double x, double y)
        {
            double distance = 0;
            std::array<double, 3> weights{};
            const Vec3d direction = other.ray(x, y);
            const Vec3d origin = other.world_from_camera.translation;
            if (!raycast::meet_plane(plane, origin, direction, distance, weights) || distance <= 0)
                return 0.0;
            const Vec3d there = camera.project(origin + direction * distance);
            return there.z > 0 ? length(Vec2d{there.x - here.x, there.y - here.y}) : 0.0;
        };
        return std::max(pixels_to(seen.x + 1, seen.y), pixels_to(seen.x, seen.y + 1));
    };
    return [=, maps = rendering::MipMaps(picture, rendering::TextureFilter::trilinear)](std::uint32_t triangle, Vec3d point,
                                                                                        const Camera& a, const Camera& b)
    {
        const Vec3d here = camera.project(point);
        const double pixels = std::max(pixels_per_pixel(triangle, point, a), pixels_per_pixel(triangle, point, b));
        return maps.sample({here.x / maps.width(), 1 - here.y / maps.height()}, level_of(pixels));
    };
}

}  // namespace

SurfacePaint texture_paint(const TexturedMesh& textured, const rendering::Lights& lights)
{
    return [&mesh = textured.mesh, maps = rendering::MipMaps(textured.image.pixels, rendering::TextureFilter::trilinear),
            lighting = rendering::Lighting(textured.mesh, lights)](std::uint32_t triangle, Vec3d point, const Camera& a,
                                                                   const Camera& b)
    {
        // The camera's ray to the point meets the triangle's plane here. A triangle without area gives any of its points.
        raycast::Hit hit{triangle, true, 0, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
        const Vec3d origin = a.world_from_camera.translation;
        raycast::meet_plane(raycast::corners(mesh, triangle), origin, point - origin, hit.distance, hit.weights);
        const Vec2d uv = raycast::texcoord(mesh, hit);
        const auto texels = [&](const Camera& camera)
        {
            const Vec3d seen = camera.project(point);
            return raycast::texels_per_pixel(mesh, triangle, uv, camera, seen.x, seen.y, maps.width(), maps.height());
        };
        return maps.sample(uv, level_of(std::max(texels(a), texels(b)))) * lighting.at(hit.triangle, hit.weights);
    };
}

namespace
{

/// The pixels of a pair that the matches need, 1.
std::pair<Raster8, Raster8> wanted_pixels(const ViewSurface& source, const ViewSurface& target, const std::vector<Match>& matches)
{
    std::pair wanted(Raster8(source.depth.width, source.depth.height), Raster8(target.depth.width, target.depth.height));
    for (const Match& match : matches)
    {
        wanted.first.at(match.x, match.y) = 1;
        for (const int y : {match.target.y.first, match.target.y.second})
            for (const int x : {match.target.x.first, match.target.x.second})
                wanted.second.at(x, y) = 1;
    }
    return wanted;
}

}  // namespace

std::vector<FramePair> frame_pairs(const std::vector<FramePlace>& frames, long gap)
{
    std::map<std::pair<std::string, long>, std::size_t> places;
    for (std::size_t i = 0; i < frames.size(); ++i)
        places.emplace(std::pair(frames[i].sequence, frames[i].number), i);
    std::vector<FramePair> pairs;
    for (std::size_t i = 0; i < frames.size(); ++i)
        if (const auto target = places.find({frames[i].sequence, frames[i].number + gap}); target != places.end())
            pairs.push_back({i, target->second});
    return pairs;
}

long smallest_gap(const std::vector<FramePlace>& frames)
{
    std::map<std::string, std::map<long, bool>> numbers;
    for (const FramePlace& frame : frames)
        numbers[frame.sequence][frame.number] = true;
    long smallest = 0;
    for (const auto& [sequence, list] : numbers)
        for (auto next = list.begin(); next != list.end();)
            if (const long number = (next++)->first; next != list.end() && (smallest == 0 || next->first - number < smallest))
                smallest = next->first - number;
    return smallest;
}

namespace
{

/// Pictures with less detail are flat: neighboring pixels differ by less than half a step of 8 bits on average.
constexpr double least_detail = 0.5 / 255;

}  // namespace

PairFigures judge_pair(const FramePair& pair, const JudgedView& source, const JudgedView& target, const Mesh& mesh,
                       const SurfacePaint& paint, double min_covisible, const Progress& progress)
{
    PairFigures figures;
    figures.pair = pair;
    const std::vector<Match> matches = covisible(source.surface, target.surface);
    figures.covisible = static_cast<double>(matches.size()) / static_cast<double>(source.surface.depth.values.size());
    figures.dropped = matches.empty() || figures.covisible < min_covisible;
    if (figures.dropped)
        return figures;

    const SurfacePaint projected = paint ? SurfacePaint() : projected_paint(mesh, source.surface.camera, source.picture);
    const SurfacePaint& shown = paint ? paint : projected;
    const auto [wanted_source, wanted_target] = wanted_pixels(source.surface, target.surface, matches);
    const Raster8 low_source = drawn(source.surface, target.surface.camera, wanted_source, shown, progress);
    const Raster8 low_target = drawn(target.surface, source.surface.camera, wanted_target, shown, progress);

    figures.value = reprojection_difference(source.picture, target.picture, matches);
    figures.floor = reprojection_difference(low_source, low_target, matches);
    figures.detail = forward_difference(source.picture, matches);
    figures.sharpness = sharpness(source.picture, matches);
    figures.flat = figures.detail < least_detail;
    figures.headline = figures.flat ? std::numeric_limits<double>::quiet_NaN() : (figures.value - figures.floor) / figures.detail;
    return figures;
}

GapFigures summary(const std::vector<PairFigures>& pairs, const evaluation::Bootstrap& bootstrap)
{
    GapFigures result;
    for (const PairFigures& pair : pairs)
    {
        result.dropped += pair.dropped ? 1 : 0;
        result.kept += pair.dropped ? 0 : 1;
        result.flat += !pair.dropped && pair.flat ? 1 : 0;
    }
    result.invalid = result.kept == 0 || result.flat * 2 >= result.kept;
    for (std::size_t i = 0; i < named_figures.size(); ++i)
    {
        const auto member = named_figures[i].second;
        std::vector<double> values;
        for (const PairFigures& pair : pairs)
            if (!pair.dropped && (member != &PairFigures::headline || !pair.flat))
                values.push_back(pair.*member);
        result.figures[i] = {evaluation::mean(values), evaluation::bootstrap_mean(values, bootstrap)};
    }
    return result;
}
