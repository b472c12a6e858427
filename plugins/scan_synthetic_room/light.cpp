#include "light.h"

#include "noise.h"
#include "textures.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace room
{

namespace
{

constexpr float cell_m = 0.075f;
constexpr int gather_rays = 48;
constexpr float exposure = 0.92f;
/// Light of further bounces, as a share of the mean; keeps corners from going black.
constexpr float ambient = 0.16f;

struct Emitter
{
    int solid;
    int face;
    Vec3f light;  ///< Radiant exitance per color.
    std::vector<FacePoint> points;
    float area_per_point;
};

/// The display's curve taken as a square: close to sRGB and cheap.
Vec3f to_linear(Vec3f display)
{
    return {display.x * display.x, display.y * display.y, display.z * display.z};
}

Vec3f times(Vec3f a, Vec3f b)
{
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

Emitter make_emitter(const Scene& scene, int solid, int face)
{
    const auto& body = scene.solids[static_cast<std::size_t>(solid)];
    const auto& material = scene.material(solid, face);
    const Vec2f extent = face_extent(body, face);
    const auto points = [](float meters) { return std::clamp(static_cast<int>(std::lround(meters / 0.28f)), 1, 5); };
    const int columns = points(extent.x), rows = points(extent.y);
    const Vec3f tint = material.pattern == Pattern::sky ? Vec3f{0.92f, 0.97f, 1.0f} : Vec3f{1.0f, 0.80f, 0.52f};
    Emitter emitter{solid, face, tint * material.emission, {}, extent.x * extent.y / static_cast<float>(columns * rows)};
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            emitter.points.push_back(face_point(body, face,
                                                {extent.x * (static_cast<float>(column) + 0.5f) / static_cast<float>(columns),
                                                 extent.y * (static_cast<float>(row) + 0.5f) / static_cast<float>(rows)}));
    return emitter;
}

std::vector<Emitter> find_emitters(const Scene& scene)
{
    std::vector<Emitter> emitters;
    for (int solid = 0; solid < static_cast<int>(scene.solids.size()); ++solid)
    {
        const auto& body = scene.solids[static_cast<std::size_t>(solid)];
        for (int face = 0; face < body.face_count(); ++face)
            if (scene.material(solid, face).emission > 0)
                emitters.push_back(make_emitter(scene, solid, face));
    }
    return emitters;
}

Vec3f direct_light(const Caster& caster, const std::vector<Emitter>& emitters, const FacePoint& at, int own_solid)
{
    Vec3f sum;
    for (const auto& emitter : emitters)
    {
        if (emitter.solid == own_solid)
            continue;
        float share = 0;
        for (const auto& point : emitter.points)
        {
            const Vec3f way = point.position - at.position;
            const float squared = dot(way, way), distance = std::sqrt(squared);
            const float leaving = -dot(way, point.normal) / distance, arriving = dot(way, at.normal) / distance;
            if (leaving <= 0 || arriving <= 0)
                continue;
            if (!caster.blocked({at.position, way}, 0.999f, emitter.solid))
                share += leaving * arriving / (pi * std::max(squared, 0.01f));
        }
        sum += emitter.light * (share * emitter.area_per_point);
    }
    return sum;
}

/// Directions about z, distributed by their cosine: a spiral that covers the disc evenly, lifted to the hemisphere.
std::array<Vec3f, gather_rays> hemisphere()
{
    std::array<Vec3f, gather_rays> directions;
    for (int i = 0; i < gather_rays; ++i)
    {
        const float squared = (static_cast<float>(i) + 0.5f) / gather_rays, radius = std::sqrt(squared);
        const float angle = 2.39996323f * static_cast<float>(i);
        directions[static_cast<std::size_t>(i)] = {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1 - squared)};
    }
    return directions;
}

/// Mean reflectance of every face.
std::vector<Vec3f> mean_colors(const Scene& scene)
{
    std::vector<Vec3f> means(scene.solids.size() * 6);
    constexpr int samples = 6;
    for (int solid = 0; solid < static_cast<int>(scene.solids.size()); ++solid)
    {
        const auto& body = scene.solids[static_cast<std::size_t>(solid)];
        for (int face = 0; face < body.face_count(); ++face)
        {
            const Vec2f extent = face_extent(body, face);
            Vec3f sum;
            for (int i = 0; i < samples * samples; ++i)
                sum += to_linear(texture(scene.material(solid, face),
                                         {extent.x * (static_cast<float>(i % samples) + 0.5f) / samples,
                                          extent.y * (static_cast<float>(i / samples) + 0.5f) / samples},
                                         extent, 0.02f));
            means[static_cast<std::size_t>(solid * 6 + face)] = sum * (1.0f / (samples * samples));
        }
    }
    return means;
}

}  // namespace

LightMap::LightMap(const Caster& caster, fresco::Progress& progress) : scene_(&caster.scene())
{
    struct Cell
    {
        int solid;
        int face;
        FacePoint point;
    };
    const Scene& scene = *scene_;
    patches_.resize(scene.solids.size() * 6);
    std::vector<Cell> cells;
    for (int solid = 0; solid < static_cast<int>(scene.solids.size()); ++solid)
    {
        const auto& body = scene.solids[static_cast<std::size_t>(solid)];
        for (int face = 0; face < body.face_count(); ++face)
        {
            auto& p = patches_[static_cast<std::size_t>(solid * 6 + face)];
            p.extent = face_extent(body, face);
            p.first = cells.size();
            p.columns = std::max(1, static_cast<int>(std::lround(p.extent.x / cell_m)));
            p.rows = std::max(1, static_cast<int>(std::lround(p.extent.y / cell_m)));
            for (int row = 0; row < p.rows; ++row)
                for (int column = 0; column < p.columns; ++column)
                {
                    auto point = face_point(body, face,
                                            {p.extent.x * (static_cast<float>(column) + 0.5f) / static_cast<float>(p.columns),
                                             p.extent.y * (static_cast<float>(row) + 0.5f) / static_cast<float>(p.rows)});
                    point.position += point.normal * 0.002f;
                    cells.push_back({solid, face, point});
                }
        }
    }

    const auto emitters = find_emitters(scene);
    values_.assign(cells.size(), {});
    fresco::parallel_for(cells.size(), 512, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_canceled();
                             for (std::size_t i = begin; i < end; ++i)
                                 values_[i] = direct_light(caster, emitters, cells[i].point, cells[i].solid);
                         });

    Vec3f sum;
    for (const auto& value : values_)
        sum += value;
    const Vec3f floor_light = sum * (ambient / static_cast<float>(cells.size()));
    const auto colors = mean_colors(scene);
    const auto directions = hemisphere();
    std::vector<Vec3f> total(cells.size());
    fresco::parallel_for(
        cells.size(), 512, progress.threads(),
        [&](std::size_t begin, std::size_t end)
        {
            progress.check_canceled();
            for (std::size_t i = begin; i < end; ++i)
            {
                const Vec3f n = cells[i].point.normal;
                const Vec3f t = normalized(std::abs(n.z) < 0.9f ? cross(Vec3f{0, 0, 1}, n) : cross(Vec3f{1, 0, 0}, n));
                const Vec3f b = cross(n, t);
                Vec3f bounced;
                for (const auto& d : directions)
                {
                    const Ray ray{cells[i].point.position, t * d.x + b * d.y + n * d.z};
                    const auto hit = caster.cast(ray);
                    if (hit.solid < 0 || hit.t < 0.01f || scene.material(hit.solid, hit.face).emission > 0)
                        continue;
                    const Vec2f where = face_coordinates(scene.solids[static_cast<std::size_t>(hit.solid)], hit.face,
                                                         ray.origin + ray.direction * hit.t);
                    bounced += times(colors[static_cast<std::size_t>(hit.solid * 6 + hit.face)],
                                     at(hit.solid, hit.face, where) + floor_light * 3);
                }
                total[i] = values_[i] + bounced * (1.0f / gather_rays) + floor_light;
            }
        });
    Vec3f mean;
    for (const auto& value : total)
        mean += value;
    const float scale = 3.0f * static_cast<float>(total.size()) / std::max(mean.x + mean.y + mean.z, 1e-6f);
    values_ = std::move(total);
    for (auto& value : values_)
        value = value * scale;
}

Vec3f LightMap::at(int solid, int face, Vec2f coordinates) const
{
    const Patch& p = patch(solid, face);
    const float x = coordinates.x / p.extent.x * static_cast<float>(p.columns) - 0.5f;
    const float y = coordinates.y / p.extent.y * static_cast<float>(p.rows) - 0.5f;
    const int x0 = whole(x), y0 = whole(y);
    const float tx = x - static_cast<float>(x0), ty = y - static_cast<float>(y0);
    const auto shape = scene_->solids[static_cast<std::size_t>(solid)].shape;
    const bool around = shape == Shape::ellipsoid || (shape == Shape::frustum && face == 0);
    const auto cell = [&](int column, int row)
    {
        column = around ? (column + p.columns) % p.columns : std::clamp(column, 0, p.columns - 1);
        row = std::clamp(row, 0, p.rows - 1);
        return values_[p.first + static_cast<std::size_t>(row * p.columns + column)];
    };
    const Vec3f low = cell(x0, y0) * (1 - tx) + cell(x0 + 1, y0) * tx;
    const Vec3f high = cell(x0, y0 + 1) * (1 - tx) + cell(x0 + 1, y0 + 1) * tx;
    return low * (1 - ty) + high * ty;
}

Vec3f LightMap::shade(int solid, int face, Vec2f coordinates, float footprint) const
{
    const auto& material = scene_->material(solid, face);
    const Vec2f extent = patch(solid, face).extent;
    const Vec3f color = texture(material, coordinates, extent, footprint);
    if (material.emission > 0)
        return color;
    const Vec3f lit = times(to_linear(color), at(solid, face, coordinates)) * exposure;
    const auto display = [](float v) { return std::sqrt(1 - std::exp(-v)); };
    return {display(lit.x), display(lit.y), display(lit.z)};
}

}  // namespace room
