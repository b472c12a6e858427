#include "light.h"

#include "noise.h"

#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace room
{
namespace
{

float fraction(float x)
{
    return x - static_cast<float>(whole(x));
}

/// 1 within `width` of the borders of a unit cell whose edge is `size` meters, 0 inside; blurred by the footprint.
float border(float t, float size, float width, float footprint)
{
    const float distance = std::min(t, 1 - t) * size;
    const float blur = std::max(footprint, 0.0015f);
    return (1 - smooth_step(width - blur, width + blur, distance)) * std::min(1.0f, width / (0.5f * blur));
}

Vec3f plaster(const Material& m, Vec2f p, Vec2f, float footprint)
{
    const float broad = fractal_noise(p.x * 1.3f, p.y * 1.3f, 3, footprint * 1.3f, m.seed);
    const float fine = fractal_noise(p.x * 18, p.y * 26, 4, footprint * 22, m.seed + 9);
    return mix(m.first, m.second, std::clamp(0.5f + 1.5f * (broad - 0.5f) + 1.1f * (fine - 0.5f), 0.0f, 1.0f));
}

/// Grain along u: stretched noise whose rings are bent by slower noise.
float grain(float u, float v, float footprint, std::uint32_t seed)
{
    const float bend = fractal_noise(u * 0.9f, v * 3, 2, footprint * 3, seed);
    const float rings = fractal_noise(u * 1.1f, v * 38 + bend * 9, 3, footprint * 38, seed + 3);
    const float pores = fractal_noise(u * 9, v * 210, 2, footprint * 200, seed + 7);
    return 0.72f * rings + 0.28f * pores;
}

Vec3f planks(const Material& m, Vec2f p, Vec2f, float footprint)
{
    const float width = 0.13f, row = std::floor(p.y / width);
    const auto row_seed = hash(static_cast<std::uint32_t>(static_cast<int>(row)), m.seed);
    const float length = 1.25f, shifted = p.x / length + unit(row_seed);
    const auto board = hash(static_cast<std::uint32_t>(whole(shifted)), row_seed);
    const float gap =
        std::max(border(fraction(p.y / width), width, 0.0022f, footprint), border(fraction(shifted), length, 0.0022f, footprint));
    const float tone = 0.34f * unit(board, 1u);
    const float g = grain(p.x + unit(board, 2u) * 40, p.y + unit(board, 3u) * 40, footprint, m.seed);
    Vec3f color = mix(m.first, m.second, std::clamp(tone + 1.5f * (g - 0.5f) + 0.3f, 0.0f, 1.0f));
    color = mix(color, Vec3f{color.x * 1.05f, color.y * 0.93f, color.z * 0.8f}, unit(board, 4u));
    return color * (1 - 0.75f * gap);
}

Vec3f brick(const Material& m, Vec2f p, Vec2f, float footprint)
{
    const float width = 0.23f, height = 0.075f, row = std::floor(p.y / height);
    const float along = p.x / width + 0.5f * std::fmod(row, 2.0f);
    const auto id = lattice(whole(along), static_cast<int>(row), m.seed);
    const float wobble = 0.004f * (value_noise(p.x * 40, p.y * 40, m.seed) - 0.5f);
    const float mortar = std::max(border(fraction(along), width, 0.006f + wobble, footprint),
                                  border(fraction(p.y / height), height, 0.006f + wobble, footprint));
    const float rough = fractal_noise(p.x * 45, p.y * 45, 4, footprint * 45, m.seed + 5);
    Vec3f stone = mix(m.first, m.second, std::clamp(unit(id) + 1.2f * (rough - 0.5f), 0.0f, 1.0f));
    stone = stone * (0.82f + 0.36f * unit(id, 3u));
    const Vec3f joint = Vec3f{0.80f, 0.77f, 0.71f} * (0.7f + 0.6f * (rough - 0.2f));
    return mix(stone, joint, mortar);
}

/// Leaf-shaped medallions in a half-drop repeat, with stems and dots.
Vec3f wallpaper(const Material& m, Vec2f p, Vec2f, float footprint)
{
    const float repeat = m.scale;
    const float column = std::floor(p.x / repeat);
    const float x = fraction(p.x / repeat) - 0.5f;
    const float y = fraction(p.y / (1.5f * repeat) + (whole(column) % 2 == 0 ? 0.0f : 0.5f)) - 0.5f;
    const float blur = std::max(0.02f, 1.5f * footprint / repeat);
    const float leaf = std::abs(x) - 0.33f * std::cos(y * pi * 1.05f) * (0.62f + 0.38f * std::cos(y * 6 * pi));
    const float vein = std::abs(std::abs(x) - std::abs(fraction(y * 6 + 2 * std::abs(x)) - 0.5f) * 0.22f) - 0.012f;
    const float dots = length(Vec2f{std::abs(x) - 0.42f, (std::abs(y) - 0.42f) * 1.5f}) - 0.055f;
    const float inside = 1 - smooth_step(-blur, blur, leaf);
    const float lines = (1 - smooth_step(-blur, blur, vein)) * inside;
    const float dot_mask = 1 - smooth_step(-blur, blur, dots);
    const float paper = fractal_noise(p.x * 30, p.y * 30, 3, footprint * 30, m.seed);
    Vec3f color = mix(m.first, m.second, std::clamp(0.85f * inside - 0.7f * lines + 0.8f * dot_mask, 0.0f, 1.0f));
    return color * (0.86f + 0.28f * paper);
}

Vec3f wood(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const bool along_u = extent.x >= extent.y;
    const float g = along_u ? grain(p.x, p.y, footprint, m.seed) : grain(p.y, p.x, footprint, m.seed);
    return mix(m.first, m.second, std::clamp(0.5f + 1.7f * (g - 0.5f), 0.0f, 1.0f));
}

/// Woven threads, warmer and cooler flecks, and faint wide stripes.
Vec3f fabric(const Material& m, Vec2f p, Vec2f, float footprint)
{
    const float thread = m.scale;
    const float keep = 1 - smooth_step(0.2f, 0.6f, footprint / thread);
    const float weave = std::sin(p.x / thread * 2 * pi) * std::sin(p.y / thread * 2 * pi) * keep;
    const float flecks = fractal_noise(p.x * 32, p.y * 32, 4, footprint * 32, m.seed);
    const float folds = fractal_noise(p.x * 3, p.y * 3, 2, footprint * 3, m.seed + 11);
    return mix(m.first, m.second, std::clamp(0.5f + 0.22f * weave + 1.3f * (flecks - 0.5f) + 0.6f * (folds - 0.5f), 0.0f, 1.0f));
}

Vec3f rug(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float edge = std::min({p.x, p.y, extent.x - p.x, extent.y - p.y});
    const float pile = 0.82f + 0.36f * fractal_noise(p.x * 60, p.y * 60, 3, footprint * 60, m.seed);
    const Vec3f cream{0.90f, 0.84f, 0.70f};
    const float blur = std::max(0.004f, footprint);
    if (edge < 0.05f)
        return mix(m.first, cream,
                   smooth_step(0.3f - blur * 8, 0.3f + blur * 8, std::abs(fraction(p.x * 12 + p.y * 12) - 0.5f))) *
               pile;
    if (edge < 0.20f)
    {
        const float zigzag = std::abs(fraction((p.x + p.y) * 5.5f) - 0.5f) + std::abs(fraction((p.x - p.y) * 5.5f) - 0.5f);
        return mix(m.second, cream, smooth_step(0.44f, 0.44f + blur * 8, zigzag)) * pile;
    }
    const Vec2f q{(p.x - extent.x / 2) / extent.y, (p.y - extent.y / 2) / extent.y};
    const float diamond = std::abs(q.x) * 1.15f + std::abs(q.y) * 1.9f;
    const float rings = fraction(diamond * 5.5f);
    const float star = std::cos(8 * std::atan2(q.y, q.x)) * 0.12f;
    const Vec3f field = std::fmod(std::floor(diamond * 5.5f + star), 2.0f) < 0.5f ? m.first : m.second;
    return mix(field, cream, 0.8f * (1 - smooth_step(0.08f, 0.08f + blur * 20, std::min(rings, 1 - rings)))) * pile;
}

/// An abstract landscape: layered hills under a swirling sky, in strokes.
Vec3f painting(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float u = p.x / extent.x, v = p.y / extent.y;
    const float edge = std::min({p.x, p.y, extent.x - p.x, extent.y - p.y});
    if (edge < 0.045f)
        return mix(Vec3f{0.36f, 0.24f, 0.10f}, Vec3f{0.80f, 0.62f, 0.30f},
                   fractal_noise(p.x * 20, p.y * 20, 3, footprint * 20, m.seed) * 0.6f + 4.0f * std::abs(edge - 0.022f) * 5);
    const float swirl = fractal_noise(u * 3, v * 3, 3, footprint * 3, m.seed);
    const float strokes = fractal_noise(u * 9 + 3 * swirl, v * 46 + 18 * swirl, 3, footprint * 46, m.seed + 2);
    Vec3f color = mix(m.first, Vec3f{0.97f, 0.86f, 0.55f}, std::clamp(1.5f * strokes - 0.3f, 0.0f, 1.0f));
    const float sun = length(Vec2f{(u - 0.68f) * extent.x, (v - 0.72f) * extent.y}) / extent.y;
    color = mix(Vec3f{1.0f, 0.72f, 0.28f}, color, smooth_step(0.09f, 0.13f, sun));
    for (int hill = 0; hill < 4; ++hill)
    {
        const auto h = static_cast<float>(hill);
        const float line = 0.56f - 0.13f * h + 0.16f * (value_noise(u * 2.5f + h * 7, 0.5f, m.seed + 20) - 0.5f) +
                           0.04f * (value_noise(u * 9, h, m.seed + 21) - 0.5f);
        if (v < line)
            color = mix(m.second, Vec3f{0.07f, 0.10f, 0.16f}, 0.25f * h) * (0.65f + 0.9f * strokes * (1 - 0.1f * h));
    }
    return color;
}

Vec3f book(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float v = p.y / extent.y;
    const float cloth = fractal_noise(p.x * 60, p.y * 60, 2, footprint * 60, m.seed);
    Vec3f color = m.first * (0.75f + 0.5f * cloth);
    const bool band = (v > 0.12f && v < 0.16f) || (v > 0.82f && v < 0.86f);
    const bool label = v > 0.58f && v < 0.76f && unit(m.seed, 1u) > 0.4f;
    return band || label ? mix(color, m.second, 0.85f) : color;
}

Vec3f leaf(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float veins = std::abs(fraction(p.x / extent.x * 14) - 0.5f);
    const float spots = fractal_noise(p.x * 30, p.y * 30, 3, footprint * 30, m.seed);
    return mix(m.first, m.second, std::clamp(0.6f * spots + 0.7f * (veins > 0.42f ? 1.0f : 0.0f), 0.0f, 1.0f));
}

/// Glaze with painted rings.
Vec3f ceramic(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float v = p.y / extent.y;
    const float flow = fractal_noise(p.x * 7, p.y * 7, 4, footprint * 7, m.seed);
    const float rings = smooth_step(0.55f, 0.75f, std::sin((v + 0.04f * flow) * 6 * pi));
    return mix(m.first, m.second, std::clamp(0.7f * rings + 0.8f * (flow - 0.35f), 0.0f, 1.0f));
}

/// Door and drawer fronts: raised fields of wood with dark grooves; `scale` is the height of a field.
Vec3f panels(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float columns = std::max(1.0f, std::round(extent.x / std::max(0.35f, m.scale)));
    const float rows = std::max(1.0f, std::round(extent.y / m.scale));
    const Vec2f size{extent.x / columns, extent.y / rows};
    const Vec2f q{fraction(p.x / size.x) * size.x, fraction(p.y / size.y) * size.y};
    const float edge = std::min({q.x, q.y, size.x - q.x, size.y - q.y});
    const float blur = std::max(0.002f, footprint);
    const auto groove = [&](float at) { return 1 - smooth_step(0.004f, 0.004f + blur, std::abs(edge - at)); };
    const float g = grain(p.y, p.x, footprint, m.seed);
    Vec3f color = mix(m.first, m.second, std::clamp(0.5f + 1.4f * (g - 0.5f), 0.0f, 1.0f));
    color = color * (1 - 0.65f * std::max(groove(0.0f), 0.7f * groove(0.06f)));
    const float knob = length(Vec2f{q.x - size.x / 2, q.y - size.y * 0.82f});
    return mix(Vec3f{0.85f, 0.68f, 0.32f}, color, smooth_step(0.016f, 0.016f + blur, knob));
}

Vec3f basket(const Material& m, Vec2f p, Vec2f, float footprint)
{
    const float size = m.scale;
    const float keep = 1 - smooth_step(0.2f, 0.7f, footprint / size);
    const bool over = (whole(p.x / size) + whole(p.y / size)) % 2 == 0;
    const float across = over ? fraction(p.y / size) : fraction(p.x / size);
    const float strand = 0.5f + keep * (std::sin(across * pi) - 0.6f) * (over ? 1.0f : 0.7f);
    return mix(m.first, m.second,
               std::clamp(strand + 0.5f * (fractal_noise(p.x * 50, p.y * 50, 2, footprint * 50, m.seed) - 0.5f), 0.0f, 1.0f));
}

/// View through the window: sky with clouds over tree tops.
Vec3f sky(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float u = p.x / extent.x, v = p.y / extent.y;
    const float cloud = smooth_step(0.45f, 0.75f, fractal_noise(u * 3, v * 5, 5, footprint * 4, m.seed));
    Vec3f color = mix(mix(Vec3f{0.86f, 0.93f, 0.98f}, Vec3f{0.48f, 0.70f, 0.95f}, v), Vec3f{1, 1, 0.98f}, cloud);
    const float tree_line = 0.30f + 0.22f * (fractal_noise(u * 6, 0.3f, 4, footprint, m.seed + 4) - 0.3f);
    if (v < tree_line)
    {
        const float leaves = fractal_noise(u * 22, v * 22, 4, footprint * 22, m.seed + 6);
        color = mix(Vec3f{0.16f, 0.30f, 0.14f}, Vec3f{0.66f, 0.78f, 0.42f}, leaves + 0.5f * (tree_line - v));
    }
    const float bar = std::min(std::abs(u - 0.5f) * extent.x, std::abs(v - 0.55f) * extent.y);
    return bar < 0.022f ? Vec3f{0.93f, 0.92f, 0.88f} : color;
}

Vec3f shade(const Material& m, Vec2f p, Vec2f extent, float footprint)
{
    const float ribs = 0.5f + 0.5f * std::cos(p.x / 0.03f * 2 * pi) * (1 - smooth_step(0.2f, 0.6f, footprint / 0.03f));
    const float glow = 1 - std::abs(p.y / extent.y - 0.45f);
    return mix(m.second, m.first, std::clamp(0.35f + 0.65f * glow - 0.25f * ribs, 0.0f, 1.0f));
}

/// Display color (sRGB, 0..1) of a face at `at` meters along it.
/// \param extent     the face's size in meters
/// \param footprint  meters covered by one sample; finer detail fades
Vec3f texture(const Material& m, Vec2f at, Vec2f extent, float footprint)
{
    // In the order of Pattern.
    constexpr std::array patterns{plaster, planks, brick,   wallpaper, wood,   fabric, rug,  painting,
                                  book,    leaf,   ceramic, panels,    basket, sky,    shade};
    return patterns[static_cast<std::size_t>(m.pattern)](m, at, extent, footprint);
}

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

template <class Visit>
void for_each_face(const Scene& scene, const Visit& visit)
{
    for (int solid = 0; solid < static_cast<int>(scene.solids.size()); ++solid)
    {
        const auto& body = scene.solids[static_cast<std::size_t>(solid)];
        for (int face = 0; face < body.face_count(); ++face)
            visit(solid, face, body);
    }
}

/// The middle of a cell of a face that is divided into columns and rows.
Vec2f cell_middle(Vec2f extent, int column, int columns, int row, int rows)
{
    return {extent.x * (static_cast<float>(column) + 0.5f) / static_cast<float>(columns),
            extent.y * (static_cast<float>(row) + 0.5f) / static_cast<float>(rows)};
}

Emitter make_emitter(const Scene& scene, int solid, int face, const Solid& body)
{
    const auto& material = scene.material(solid, face);
    const Vec2f extent = face_extent(body, face);
    const auto points = [](float meters) { return std::clamp(static_cast<int>(std::lround(meters / 0.28f)), 1, 5); };
    const int columns = points(extent.x), rows = points(extent.y);
    const Vec3f tint = material.pattern == Pattern::sky ? Vec3f{0.92f, 0.97f, 1.0f} : Vec3f{1.0f, 0.80f, 0.52f};
    Emitter emitter{solid, face, tint * material.emission, {}, extent.x * extent.y / static_cast<float>(columns * rows)};
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            emitter.points.push_back(face_point(body, face, cell_middle(extent, column, columns, row, rows)));
    return emitter;
}

std::vector<Emitter> find_emitters(const Scene& scene)
{
    std::vector<Emitter> emitters;
    for_each_face(scene,
                  [&](int solid, int face, const Solid& body)
                  {
                      if (scene.material(solid, face).emission > 0)
                          emitters.push_back(make_emitter(scene, solid, face, body));
                  });
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
    for_each_face(scene,
                  [&](int solid, int face, const Solid& body)
                  {
                      const Vec2f extent = face_extent(body, face);
                      Vec3f sum;
                      for (int i = 0; i < samples * samples; ++i)
                          sum +=
                              to_linear(texture(scene.material(solid, face),
                                                cell_middle(extent, i % samples, samples, i / samples, samples), extent, 0.02f));
                      means[static_cast<std::size_t>(solid * 6 + face)] = sum * (1.0f / (samples * samples));
                  });
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
    for_each_face(scene,
                  [&](int solid, int face, const Solid& body)
                  {
                      auto& p = patches_[static_cast<std::size_t>(solid * 6 + face)];
                      p.extent = face_extent(body, face);
                      p.first = cells.size();
                      p.columns = std::max(1, static_cast<int>(std::lround(p.extent.x / cell_m)));
                      p.rows = std::max(1, static_cast<int>(std::lround(p.extent.y / cell_m)));
                      for (int row = 0; row < p.rows; ++row)
                          for (int column = 0; column < p.columns; ++column)
                          {
                              auto point = face_point(body, face, cell_middle(p.extent, column, p.columns, row, p.rows));
                              point.position += point.normal * 0.002f;
                              cells.push_back({solid, face, point});
                          }
                  });

    const auto emitters = find_emitters(scene);
    values_.assign(cells.size(), {});
    fresco::parallel_items(cells.size(), 512, progress,
                           [&](std::size_t i) { values_[i] = direct_light(caster, emitters, cells[i].point, cells[i].solid); });

    Vec3f sum;
    for (const auto& value : values_)
        sum += value;
    const Vec3f floor_light = sum * (ambient / static_cast<float>(cells.size()));
    const auto colors = mean_colors(scene);
    const auto directions = hemisphere();
    std::vector<Vec3f> total(cells.size());
    fresco::parallel_items(
        cells.size(), 512, progress,
        [&](std::size_t i)
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
    const auto shape = scene_->solids[static_cast<std::size_t>(solid)].shape;
    const bool around = shape == Shape::ellipsoid || (shape == Shape::frustum && face == 0);
    const auto cell = [&](int column, int row)
    {
        column = around ? (column + p.columns) % p.columns : std::clamp(column, 0, p.columns - 1);
        row = std::clamp(row, 0, p.rows - 1);
        return values_[p.first + static_cast<std::size_t>(row * p.columns + column)];
    };
    return fresco::numerics::bilinear(fresco::numerics::between(x), fresco::numerics::between(y), cell);
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
