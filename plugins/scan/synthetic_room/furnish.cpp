#include "furnish.h"

#include "noise.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace room
{
namespace
{

const Vec3f dark_wood{0.29f, 0.17f, 0.09f};
const Vec3f light_wood{0.66f, 0.44f, 0.24f};

std::array<Vec3f, 3> turned(float yaw)
{
    const float c = std::cos(yaw), s = std::sin(yaw);
    return {Vec3f{c, s, 0}, Vec3f{-s, c, 0}, Vec3f{0, 0, 1}};
}

/// Puts bodies into a scene. Pieces of furniture stand on the floor at (x, y) and are turned about the vertical by `yaw`.
class Furniture
{
  public:
    Furniture(Scene& scene, std::uint32_t seed) : scene_(scene), seed_(seed) {}

    std::uint16_t material(Material m)
    {
        m.seed = hash(seed_, 1000u + static_cast<std::uint32_t>(scene_.materials.size()));
        scene_.materials.push_back(m);
        return static_cast<std::uint16_t>(scene_.materials.size() - 1);
    }

    float random() { return unit(seed_, ++drawn_); }
    float random(float from, float to) { return mix(from, to, random()); }

    /// A frame on the floor in which furniture is built: local x, y, z in meters.
    void stand_at(float x, float y, float yaw)
    {
        origin_ = {x, y, 0};
        yaw_ = yaw;
    }

    /// Box by its center and edges.
    Solid& box(Vec3f center, Vec3f edges, std::uint16_t material, float yaw = 0)
    {
        const auto frame = turned(yaw_);
        Solid solid;
        solid.shape = Shape::box;
        solid.part = part_;
        solid.center = origin_ + frame[0] * center.x + frame[1] * center.y + frame[2] * center.z;
        solid.axes = turned(yaw_ + yaw);
        solid.size = edges * 0.5f;
        solid.materials.fill(material);
        scene_.solids.push_back(solid);
        return scene_.solids.back();
    }

    /// The part of the room that the following boxes belong to.
    void begin(Part part) { part_ = part; }
    /// Round body between z0 and z1.
    Solid& round(float x, float y, float z0, float z1, float bottom_radius, float top_radius, std::uint16_t material)
    {
        auto& solid = box({x, y, 0.5f * (z0 + z1)}, {}, material);
        solid.shape = Shape::frustum;
        solid.size = {bottom_radius, top_radius, 0.5f * (z1 - z0)};
        return solid;
    }

    Solid& ball(Vec3f center, Vec3f radii, std::uint16_t material)
    {
        auto& solid = box(center, {}, material);
        solid.shape = Shape::ellipsoid;
        solid.size = radii;
        return solid;
    }

    void table(std::uint16_t wood)
    {
        box({0, 0, 0.735f}, {1.30f, 0.80f, 0.05f}, wood);
        box({0, 0, 0.67f}, {1.10f, 0.60f, 0.08f}, wood);
        for (const float x : {-0.55f, 0.55f})
            for (const float y : {-0.31f, 0.31f})
                box({x, y, 0.355f}, {0.075f, 0.075f, 0.71f}, wood);
    }

    void still_life()
    {
        const auto glaze = material({Pattern::ceramic, {0.16f, 0.33f, 0.55f}, {0.93f, 0.91f, 0.84f}});
        const auto clay = material({Pattern::ceramic, {0.70f, 0.36f, 0.20f}, {0.92f, 0.80f, 0.60f}});
        const auto orange = material({Pattern::leaf, {0.92f, 0.46f, 0.08f}, {0.98f, 0.66f, 0.20f}});
        const auto apple = material({Pattern::leaf, {0.68f, 0.10f, 0.10f}, {0.86f, 0.62f, 0.22f}});
        const float top = 0.76f;
        round(0.34f, 0.12f, top, top + 0.16f, 0.05f, 0.095f, glaze);
        round(0.34f, 0.12f, top + 0.16f, top + 0.28f, 0.095f, 0.045f, glaze);
        round(-0.10f, -0.02f, top, top + 0.07f, 0.08f, 0.165f, clay);
        const std::array<Vec3f, 5> fruit{Vec3f{-0.16f, 0.02f, 0.075f}, Vec3f{-0.05f, 0.05f, 0.08f}, Vec3f{-0.07f, -0.08f, 0.075f},
                                         Vec3f{-0.17f, -0.07f, 0.07f}, Vec3f{-0.11f, -0.01f, 0.125f}};
        for (std::size_t i = 0; i < fruit.size(); ++i)
            ball(fruit[i] + Vec3f{0, 0, top}, {0.047f, 0.047f, 0.044f}, i % 2 == 0 ? orange : apple);
        round(0.48f, -0.22f, top, top + 0.10f, 0.042f, 0.045f, glaze);
        const std::array<Vec3f, 3> cloths{Vec3f{0.52f, 0.13f, 0.14f}, Vec3f{0.15f, 0.36f, 0.33f}, Vec3f{0.80f, 0.66f, 0.32f}};
        for (std::size_t i = 0; i < cloths.size(); ++i)
        {
            const auto cloth = material({Pattern::book, cloths[i], {0.92f, 0.85f, 0.62f}});
            box({-0.46f, 0.20f, top + 0.018f + 0.036f * static_cast<float>(i)},
                {0.24f - 0.02f * static_cast<float>(i), 0.17f, 0.036f}, cloth, random(-0.5f, 0.5f));
        }
    }

    void chair(std::uint16_t wood, std::uint16_t cushion)
    {
        box({0, 0, 0.435f}, {0.44f, 0.43f, 0.04f}, wood);
        box({0, 0.01f, 0.47f}, {0.40f, 0.38f, 0.04f}, cushion);
        for (const float x : {-0.195f, 0.195f})
        {
            box({x, 0.19f, 0.21f}, {0.045f, 0.045f, 0.42f}, wood);
            box({x, -0.20f, 0.48f}, {0.045f, 0.045f, 0.96f}, wood);
        }
        for (const float z : {0.62f, 0.76f, 0.90f})
            box({0, -0.20f, z}, {0.36f, 0.03f, 0.07f}, wood);
    }

    void shelf(float width, float height, std::uint16_t wood)
    {
        const float depth = 0.30f, board = 0.03f;
        const float half = width / 2;
        box({0, 0.01f, height / 2}, {width, 0.02f, height}, wood);
        for (const float x : {-half, half})
            box({x, depth / 2, height / 2}, {board, depth, height}, wood);
        const int rows = std::max(2, static_cast<int>(height / 0.36f));
        const float step = (height - board) / static_cast<float>(rows);
        for (int i = 0; i <= rows; ++i)
            box({0, depth / 2, board / 2 + step * static_cast<float>(i)}, {width, depth, board}, wood);
        const auto straw = material({Pattern::basket, {0.45f, 0.30f, 0.14f}, {0.86f, 0.68f, 0.40f}, 0.03f});
        const auto glaze = material({Pattern::ceramic, {0.20f, 0.42f, 0.40f}, {0.92f, 0.88f, 0.74f}});
        for (int i = 0; i < rows; ++i)
        {
            const float z = board + step * static_cast<float>(i), free = step - board;
            if (i == 0)
            {
                for (const float x : {-0.25f * width, 0.25f * width})
                    box({x, 0.15f, z + 0.4f * free}, {0.42f * width, 0.24f, 0.8f * free}, straw);
                continue;
            }
            const float reserved = i % 2 == 0 ? 0.3f : 0.0f;
            book_row(-half + board, half - board - reserved, 0.025f, z, free);
            if (reserved > 0)
                round(half - 0.17f, 0.16f, z, z + 0.7f * free, 0.05f, 0.1f, glaze);
        }
        for (const float x : {-0.3f * width, 0.05f * width})
            box({x, 0.15f, height + 0.09f}, {0.30f, 0.24f, 0.18f}, straw, random(-0.2f, 0.2f));
        round(0.33f * width, 0.15f, height, height + 0.22f, 0.06f, 0.11f, glaze);
    }

    void sofa(float width, std::uint16_t cloth, std::uint16_t cushion)
    {
        const float depth = 0.86f;
        box({0, 0.5f * depth, 0.23f}, {width, depth, 0.30f}, cloth);
        box({0, 0.11f, 0.58f}, {width, 0.22f, 0.46f}, cloth);
        for (const float side : {-1.0f, 1.0f})
        {
            box({side * (0.5f * width - 0.10f), 0.5f * depth, 0.36f}, {0.20f, depth, 0.52f}, cloth);
            box({side * (0.25f * width - 0.05f), 0.54f, 0.43f}, {0.5f * width - 0.12f, 0.62f, 0.12f}, cloth);
            auto& pillow = ball({side * (0.5f * width - 0.42f), 0.34f, 0.66f}, {0.23f, 0.10f, 0.20f}, cushion);
            pillow.axes = {pillow.axes[0], normalized(pillow.axes[1] + pillow.axes[2] * 0.4f),
                           normalized(pillow.axes[2] - pillow.axes[1] * 0.4f)};
            for (const float y : {0.08f, depth - 0.08f})
                round(side * (0.5f * width - 0.08f), y, 0, 0.09f, 0.025f, 0.035f, cushion);
        }
    }

    void sideboard(float width, std::uint16_t front, std::uint16_t top)
    {
        box({0, 0.22f, 0.43f}, {width, 0.42f, 0.66f}, front);
        box({0, 0.22f, 0.78f}, {width + 0.06f, 0.46f, 0.04f}, top);
        for (const float x : {-0.5f * width + 0.06f, 0.5f * width - 0.06f})
            for (const float y : {0.06f, 0.38f})
                round(x, y, 0, 0.11f, 0.02f, 0.032f, top);
        const auto glaze = material({Pattern::ceramic, {0.78f, 0.30f, 0.22f}, {0.95f, 0.86f, 0.66f}});
        const auto brass = material({Pattern::ceramic, {0.62f, 0.45f, 0.16f}, {0.90f, 0.74f, 0.36f}});
        round(-0.34f * width, 0.22f, 0.80f, 1.02f, 0.06f, 0.12f, glaze);
        round(-0.34f * width, 0.22f, 1.02f, 1.14f, 0.12f, 0.06f, glaze);
        box({0.30f * width, 0.20f, 0.91f}, {0.34f, 0.18f, 0.22f}, material({Pattern::panels, dark_wood, light_wood, 0.22f}),
            0.12f);
        round(0.02f * width, 0.25f, 0.80f, 0.84f, 0.06f, 0.05f, brass);
        round(0.02f * width, 0.25f, 0.84f, 1.06f, 0.02f, 0.02f, brass);
        ball({0.02f * width, 0.25f, 1.09f}, {0.055f, 0.055f, 0.055f}, brass);
    }

    void plant()
    {
        const auto pot = material({Pattern::ceramic, {0.66f, 0.34f, 0.20f}, {0.90f, 0.74f, 0.52f}});
        const auto earth = material({Pattern::plaster, {0.20f, 0.13f, 0.08f}, {0.34f, 0.24f, 0.15f}});
        const auto stem = material({Pattern::wood, {0.26f, 0.20f, 0.10f}, {0.46f, 0.38f, 0.18f}});
        const std::array<std::uint16_t, 2> greens{material({Pattern::leaf, {0.10f, 0.30f, 0.12f}, {0.46f, 0.62f, 0.24f}}),
                                                  material({Pattern::leaf, {0.16f, 0.38f, 0.16f}, {0.62f, 0.72f, 0.32f}})};
        round(0, 0, 0, 0.34f, 0.13f, 0.20f, pot).materials[2] = earth;
        round(0, 0, 0.34f, 1.05f, 0.028f, 0.02f, stem);
        constexpr int leaves = 17;
        for (int i = 0; i < leaves; ++i)
        {
            const float turn = 2.4f * static_cast<float>(i) + random(-0.2f, 0.2f);
            const float up = static_cast<float>(i) / leaves;
            const float rise = mix(0.05f, 1.15f, up) + random(-0.1f, 0.1f);
            const float size = mix(0.24f, 0.15f, up);
            const Vec3f along =
                normalized(Vec3f{std::cos(turn) * std::cos(rise), std::sin(turn) * std::cos(rise), std::sin(rise)});
            const Vec3f across = normalized(Vec3f{-std::sin(turn), std::cos(turn), 0.15f});
            auto& leaf = ball(Vec3f{0, 0, mix(0.55f, 1.08f, up)} + along * (0.95f * size), {size, 0.45f * size, 0.018f},
                              greens[static_cast<std::size_t>(i) % 2]);
            const Vec3f normal = normalized(cross(along, across));
            leaf.axes = {leaf.to_world(along), leaf.to_world(cross(normal, along)), leaf.to_world(normal)};
        }
    }

    void floor_lamp(std::uint16_t glowing)
    {
        const auto metal = material({Pattern::ceramic, {0.16f, 0.15f, 0.14f}, {0.45f, 0.40f, 0.32f}});
        round(0, 0, 0, 0.03f, 0.16f, 0.15f, metal);
        round(0, 0, 0.03f, 1.36f, 0.022f, 0.022f, metal);
        round(0, 0, 1.34f, 1.66f, 0.22f, 0.14f, glowing);
    }

    /// Hangs from the ceiling at height `ceiling`.
    void pendant(float ceiling, std::uint16_t glowing)
    {
        const auto cord = material({Pattern::ceramic, {0.15f, 0.14f, 0.13f}, {0.35f, 0.33f, 0.30f}});
        const float top = ceiling - 0.42f;
        round(0, 0, ceiling - 0.04f, ceiling, 0.07f, 0.06f, cord);
        round(0, 0, top, ceiling, 0.016f, 0.016f, cord);
        round(0, 0, top - 0.24f, top, 0.26f, 0.11f, glowing);
    }

    /// Center of the picture at height z; the wall is behind, at local y = 0, the picture in front of it.
    void picture(float width, float height, float z, Vec3f sky, Vec3f hills)
    {
        const auto canvas = material({Pattern::painting, sky, hills});
        const auto frame = material({Pattern::wood, dark_wood, light_wood});
        auto& solid = box({0, 0.025f, z}, {width, 0.05f, height}, frame);
        solid.part = Part::walls;
        solid.materials[2] = solid.materials[3] = canvas;
    }

    void radiator(float width)
    {
        const auto enamel = material({Pattern::plaster, {0.80f, 0.78f, 0.72f}, {0.95f, 0.94f, 0.90f}});
        const int ribs = static_cast<int>(width / 0.10f);
        for (int i = 0; i < ribs; ++i)
            round((static_cast<float>(i) + 0.5f) * width / static_cast<float>(ribs) - width / 2, 0.07f, 0.10f, 0.68f, 0.036f,
                  0.036f, enamel);
        for (const float z : {0.14f, 0.63f})
            box({0, 0.07f, z}, {width, 0.05f, 0.06f}, enamel);
    }

    /// `right` and `left` of a window of this width, from z0 to z1.
    void curtains(float width, float z0, float z1, std::uint16_t cloth)
    {
        const auto rod = material({Pattern::wood, dark_wood, light_wood});
        box({0, 0.09f, z1 + 0.02f}, {width + 0.7f, 0.035f, 0.035f}, rod);
        for (const float side : {-1.0f, 1.0f})
            for (int fold = 0; fold < 5; ++fold)
            {
                const float x = side * (width / 2 + 0.28f - 0.072f * static_cast<float>(fold));
                const float radius = random(0.04f, 0.052f);
                round(x, 0.09f, z0, z1, radius * 1.1f, radius, cloth);
            }
    }

  private:
    void book_row(float x0, float x1, float y, float z, float room_above)
    {
        static const std::array<Vec3f, 9> cloths{
            Vec3f{0.55f, 0.13f, 0.12f}, Vec3f{0.12f, 0.25f, 0.42f}, Vec3f{0.80f, 0.62f, 0.20f},
            Vec3f{0.15f, 0.36f, 0.26f}, Vec3f{0.90f, 0.85f, 0.72f}, Vec3f{0.35f, 0.20f, 0.36f},
            Vec3f{0.82f, 0.42f, 0.18f}, Vec3f{0.24f, 0.44f, 0.50f}, Vec3f{0.22f, 0.18f, 0.16f}};
        for (float x = x0; x < x1 - 0.03f;)
        {
            const float thickness = std::min(random(0.03f, 0.06f), x1 - x);
            if (random() < 0.12f)
            {
                x += random(0.06f, 0.14f);
                continue;
            }
            const auto pick = static_cast<std::size_t>(random(0, 8.999f));
            const auto cloth =
                material({Pattern::book, cloths[pick], cloths[(pick + 4) % 9] * 0.5f + Vec3f{0.45f, 0.42f, 0.32f}});
            const float height = random(0.6f, 0.94f) * room_above, depth = random(0.17f, 0.24f);
            box({x + thickness / 2, y + depth / 2, z + height / 2}, {thickness * 0.97f, depth, height}, cloth);
            x += thickness;
        }
    }

    Scene& scene_;
    std::uint32_t seed_;
    std::uint32_t drawn_ = 0;
    Vec3f origin_;
    float yaw_ = 0;
    Part part_ = Part::furniture;
};

constexpr float bay = 3.0f;  ///< One more group of furniture for each so many meters beyond the first group's length.
constexpr float first_length = 5.0f;

// Faces of the hollow room.
constexpr std::size_t west = 0, east = 1, south = 2, north = 3, bottom = 4, top = 5;

/// Colors that go together, the darkest and the lightest of each material.
namespace colors
{
using Range = std::array<Vec3f, 2>;
constexpr Range wall{Vec3f{0.20f, 0.36f, 0.38f}, {0.78f, 0.76f, 0.58f}};
constexpr Range cloth{Vec3f{0.13f, 0.30f, 0.34f}, {0.36f, 0.58f, 0.58f}};
constexpr Range cushion{Vec3f{0.72f, 0.34f, 0.14f}, {0.95f, 0.72f, 0.36f}};
constexpr Range curtain{Vec3f{0.62f, 0.24f, 0.20f}, {0.88f, 0.56f, 0.44f}};
constexpr Range rug{Vec3f{0.60f, 0.14f, 0.13f}, {0.13f, 0.22f, 0.36f}};
constexpr Range door{Vec3f{0.24f, 0.34f, 0.34f}, {0.48f, 0.58f, 0.54f}};
}  // namespace colors

struct Palette
{
    std::uint16_t oak, walnut, cloth, cushion, curtain, glow, cabinet, beam, skirting;
};

Palette make_palette(Furniture& f)
{
    return {.oak = f.material({Pattern::wood, {0.48f, 0.29f, 0.13f}, {0.84f, 0.62f, 0.36f}}),
            .walnut = f.material({Pattern::wood, {0.20f, 0.11f, 0.06f}, {0.50f, 0.31f, 0.18f}}),
            .cloth = f.material({Pattern::fabric, colors::cloth[0], colors::cloth[1], 0.014f}),
            .cushion = f.material({Pattern::fabric, colors::cushion[0], colors::cushion[1], 0.018f}),
            .curtain = f.material({Pattern::fabric, colors::curtain[0], colors::curtain[1], 0.02f}),
            .glow = f.material({Pattern::shade, {1.0f, 0.93f, 0.74f}, {0.93f, 0.68f, 0.36f}, 1, 0, 5.0f}),
            .cabinet = f.material({Pattern::panels, {0.30f, 0.17f, 0.09f}, {0.60f, 0.38f, 0.20f}, 0.34f}),
            .beam = f.material({Pattern::wood, {0.28f, 0.17f, 0.09f}, {0.58f, 0.40f, 0.24f}}),
            .skirting = f.material({Pattern::wood, {0.78f, 0.75f, 0.68f}, {0.95f, 0.93f, 0.88f}})};
}

void build_shell(Scene& scene, Furniture& f, const Palette& palette)
{
    Solid shell;
    shell.hollow = true;
    shell.center = scene.size * 0.5f;
    shell.size = scene.size * 0.5f;
    const auto plaster = f.material({Pattern::plaster, {0.80f, 0.70f, 0.54f}, {0.97f, 0.92f, 0.80f}});
    shell.materials[west] = f.material({Pattern::brick, {0.48f, 0.20f, 0.13f}, {0.78f, 0.44f, 0.30f}});
    shell.materials[east] = plaster;
    shell.materials[south] = plaster;
    shell.materials[north] = f.material({Pattern::wallpaper, colors::wall[0], colors::wall[1], 0.24f});
    shell.materials[bottom] = f.material({Pattern::planks, {0.34f, 0.19f, 0.09f}, {0.80f, 0.55f, 0.31f}});
    shell.materials[top] = f.material({Pattern::plaster, {0.84f, 0.80f, 0.72f}, {0.99f, 0.98f, 0.94f}});
    scene.solids.push_back(shell);

    const float l = scene.size.x, w = scene.size.y, h = scene.size.z;
    f.stand_at(0, 0, 0);
    f.begin(Part::walls);
    f.box({l / 2, w - 0.01f, 0.05f}, {l, 0.02f, 0.10f}, palette.skirting);
    f.box({0.01f, w / 2, 0.05f}, {0.02f, w, 0.10f}, palette.skirting);
    f.box({l - 0.01f, w / 2, 0.05f}, {0.02f, w, 0.10f}, palette.skirting);
    f.box({0.5f * l + 0.6f, 0.01f, 0.05f}, {l - 1.2f, 0.02f, 0.10f}, palette.skirting);
    f.begin(Part::ceiling);
    const int beams = std::max(2, static_cast<int>(std::lround(l / 1.3f)));
    for (int i = 0; i < beams; ++i)
        f.box({l * (static_cast<float>(i) + 0.5f) / static_cast<float>(beams), w / 2, h - 0.07f}, {0.15f, w, 0.14f},
              palette.beam);
    f.begin(Part::furniture);
}

void add_window(const Scene& scene, Furniture& f, const Palette& palette)
{
    const float width = std::min(1.5f, 0.42f * scene.size.y), z0 = 0.90f, z1 = std::min(2.1f, scene.size.z - 0.3f);
    const auto glass = f.material({Pattern::sky, {1, 1, 1}, {1, 1, 1}, 1, 0, 7.0f});
    // Local y points from the wall into the room.
    f.stand_at(scene.size.x, 0.5f * scene.size.y, pi / 2);
    f.begin(Part::walls);
    auto& pane = f.box({0, 0.015f, 0.5f * (z0 + z1)}, {width, 0.03f, z1 - z0}, palette.skirting);
    pane.materials[3] = glass;
    for (const float side : {-1.0f, 1.0f})
        f.box({side * (width / 2 + 0.03f), 0.035f, 0.5f * (z0 + z1)}, {0.06f, 0.07f, z1 - z0 + 0.12f}, palette.skirting);
    f.box({0, 0.035f, z1 + 0.03f}, {width + 0.12f, 0.07f, 0.06f}, palette.skirting);
    f.begin(Part::furniture);
    f.box({0, 0.09f, z0 - 0.03f}, {width + 0.2f, 0.18f, 0.05f}, palette.skirting);
    f.curtains(width + 0.2f, 0.06f, z1 + 0.12f, palette.curtain);
    f.radiator(width * 0.9f);
}

void add_door(const Scene& scene, Furniture& f, const Palette& palette)
{
    f.stand_at(0.62f, 0, 0);
    const float height = std::min(2.02f, scene.size.z - 0.12f);
    f.begin(Part::walls);
    f.box({0, 0.02f, height / 2}, {0.86f, 0.04f, height}, f.material({Pattern::panels, colors::door[0], colors::door[1], 0.66f}));
    for (const float side : {-1.0f, 1.0f})
        f.box({side * 0.47f, 0.03f, height / 2}, {0.09f, 0.06f, height}, palette.skirting);
    f.box({0, 0.03f, height + 0.045f}, {1.03f, 0.06f, 0.09f}, palette.skirting);
    f.begin(Part::furniture);
}

void add_dining_group(const Scene& scene, Furniture& f, const Palette& palette, float x, float y)
{
    const auto pile = f.material({Pattern::rug, colors::rug[0], colors::rug[1]});
    const auto fringe = f.material({Pattern::fabric, {0.62f, 0.55f, 0.42f}, {0.86f, 0.80f, 0.66f}, 0.02f});
    f.stand_at(x, y, 0.06f);
    Solid& rug = f.box({0, 0, 0.008f}, {2.3f, 1.6f, 0.016f}, fringe);
    rug.materials[5] = pile;
    rug.part = Part::floor;
    f.stand_at(x, y, 0.10f);
    f.table(palette.oak);
    f.still_life();
    const std::array<Vec3f, 4> seats{Vec3f{-0.30f, -0.58f, 0.2f}, Vec3f{0.36f, -0.66f, -0.5f}, Vec3f{0.28f, 0.60f, pi + 0.12f},
                                     Vec3f{-0.92f, 0.05f, -pi / 2 + 0.25f}};
    for (const auto seat : seats)
    {
        f.stand_at(x + seat.x, y + seat.y, seat.z);
        f.chair(palette.walnut, palette.cushion);
    }
    f.stand_at(x, y, 0);
    f.pendant(scene.size.z, palette.glow);
}

/// Furniture of a longer room: an armchair on a rug, a second shelf, pictures and a plant.
void add_bay(const Scene& scene, Furniture& f, const Palette& palette, float x)
{
    const float w = scene.size.y;
    const auto pile = f.material({Pattern::rug, colors::rug[1], colors::rug[0]});
    f.stand_at(x, 0.48f * w, -0.1f);
    f.box({0, 0, 0.008f}, {1.7f, 1.2f, 0.016f}, pile).part = Part::floor;
    f.stand_at(x - 0.5f, 0.48f * w, -pi / 2 + 0.5f);
    f.sofa(0.95f, palette.cloth, palette.cushion);
    f.stand_at(x + 0.45f, 0.42f * w, 0.3f);
    f.round(0, 0, 0, 0.05f, 0.16f, 0.16f, palette.walnut);
    f.round(0, 0, 0.05f, 0.46f, 0.035f, 0.035f, palette.walnut);
    f.round(0, 0, 0.46f, 0.50f, 0.30f, 0.30f, palette.oak);
    f.stand_at(x, w, pi);
    f.shelf(1.1f, std::min(1.5f, scene.size.z - 0.6f), palette.oak);
    f.stand_at(x, 0, 0);
    f.picture(1.0f, 0.7f, 1.5f, {0.72f, 0.52f, 0.42f}, {0.36f, 0.30f, 0.44f});
    f.stand_at(x + 0.95f, 0.4f, 1.3f);
    f.plant();
    f.stand_at(x, 0.5f * w, 0);
    f.pendant(scene.size.z, palette.glow);
}

void furnish_walls(const Scene& scene, Furniture& f, const Palette& palette, float length)
{
    const float w = scene.size.y, h = scene.size.z;
    f.stand_at(0.85f, w, pi);
    f.shelf(1.3f, std::min(2.0f, h - 0.35f), palette.walnut);
    const float sofa_x = std::max(2.6f, length - 1.75f);
    f.stand_at(sofa_x, w - 0.03f, pi);
    f.sofa(1.8f, palette.cloth, palette.cushion);
    f.stand_at(sofa_x, w, pi);
    f.picture(1.15f, 0.78f, 1.48f, {0.26f, 0.42f, 0.62f}, {0.22f, 0.44f, 0.32f});
    const float board_x = std::max(2.2f, 0.62f * length);
    f.stand_at(board_x, 0.01f, 0);
    f.sideboard(1.4f, palette.cabinet, palette.walnut);
    f.stand_at(board_x, 0, 0);
    f.picture(0.95f, 0.68f, 1.56f, {0.86f, 0.50f, 0.28f}, {0.48f, 0.22f, 0.26f});
    f.stand_at(0, 0.52f * w, -pi / 2);
    f.picture(0.6f, 0.8f, 1.5f, {0.30f, 0.46f, 0.44f}, {0.62f, 0.40f, 0.16f});
    f.stand_at(scene.size.x - 0.42f, w - 0.42f, 0.4f);
    f.plant();
    f.stand_at(scene.size.x - 0.4f, 0.42f, 0);
    f.floor_lamp(palette.glow);
}

}  // namespace

Scene furnish(Vec3f size, std::uint32_t seed)
{
    Scene scene;
    scene.size = size;
    Furniture furniture(scene, hash(seed, 77u));
    const auto palette = make_palette(furniture);
    build_shell(scene, furniture, palette);
    add_window(scene, furniture, palette);
    add_door(scene, furniture, palette);
    const int bays = std::max(0, static_cast<int>((size.x - first_length) / bay + 0.5f));
    const float length = bays > 0 ? first_length : size.x;
    furnish_walls(scene, furniture, palette, length);
    add_dining_group(scene, furniture, palette, std::max(1.65f, 0.44f * length), 0.47f * size.y);
    const float step = bays > 0 ? (size.x - first_length - 0.4f) / static_cast<float>(bays) : 0;
    for (int i = 0; i < bays; ++i)
        add_bay(scene, furniture, palette, first_length - 0.1f + step * (static_cast<float>(i) + 0.4f));
    return scene;
}

}  // namespace room
