#include "furnish.h"

#include "furniture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace room
{

namespace
{

constexpr float bay = 3.0f;  ///< One more group of furniture for each so many meters beyond the first group's length.
constexpr float first_length = 5.0f;

// Faces of the hollow room.
constexpr std::size_t west = 0, east = 1, south = 2, north = 3, bottom = 4, top = 5;

/// Colors that go together; the seed picks one.
struct Colors
{
    std::array<Vec3f, 2> wall, cloth, cushion, curtain, rug, door;
};

const std::array<Colors, 3> color_sets{Colors{.wall = {Vec3f{0.44f, 0.22f, 0.20f}, {0.86f, 0.70f, 0.52f}},
                                              .cloth = {Vec3f{0.40f, 0.30f, 0.14f}, {0.70f, 0.58f, 0.32f}},
                                              .cushion = {Vec3f{0.10f, 0.34f, 0.36f}, {0.44f, 0.68f, 0.64f}},
                                              .curtain = {Vec3f{0.56f, 0.42f, 0.18f}, {0.90f, 0.80f, 0.54f}},
                                              .rug = {Vec3f{0.12f, 0.32f, 0.34f}, {0.64f, 0.36f, 0.14f}},
                                              .door = {Vec3f{0.36f, 0.20f, 0.12f}, {0.60f, 0.38f, 0.24f}}},
                                       Colors{.wall = {Vec3f{0.20f, 0.36f, 0.38f}, {0.78f, 0.76f, 0.58f}},
                                              .cloth = {Vec3f{0.13f, 0.30f, 0.34f}, {0.36f, 0.58f, 0.58f}},
                                              .cushion = {Vec3f{0.72f, 0.34f, 0.14f}, {0.95f, 0.72f, 0.36f}},
                                              .curtain = {Vec3f{0.62f, 0.24f, 0.20f}, {0.88f, 0.56f, 0.44f}},
                                              .rug = {Vec3f{0.60f, 0.14f, 0.13f}, {0.13f, 0.22f, 0.36f}},
                                              .door = {Vec3f{0.24f, 0.34f, 0.34f}, {0.48f, 0.58f, 0.54f}}},
                                       Colors{.wall = {Vec3f{0.30f, 0.36f, 0.22f}, {0.84f, 0.80f, 0.60f}},
                                              .cloth = {Vec3f{0.44f, 0.14f, 0.14f}, {0.72f, 0.36f, 0.32f}},
                                              .cushion = {Vec3f{0.70f, 0.60f, 0.40f}, {0.94f, 0.88f, 0.70f}},
                                              .curtain = {Vec3f{0.20f, 0.32f, 0.46f}, {0.54f, 0.68f, 0.78f}},
                                              .rug = {Vec3f{0.16f, 0.24f, 0.42f}, {0.56f, 0.20f, 0.20f}},
                                              .door = {Vec3f{0.22f, 0.26f, 0.40f}, {0.46f, 0.52f, 0.64f}}}};

struct Palette
{
    Colors colors;
    std::uint16_t oak, walnut, cloth, cushion, curtain, glow, cabinet, beam, skirting;
};

Palette make_palette(Furniture& f, const Colors& c)
{
    return {.colors = c,
            .oak = f.material({Pattern::wood, {0.48f, 0.29f, 0.13f}, {0.84f, 0.62f, 0.36f}}),
            .walnut = f.material({Pattern::wood, {0.20f, 0.11f, 0.06f}, {0.50f, 0.31f, 0.18f}}),
            .cloth = f.material({Pattern::fabric, c.cloth[0], c.cloth[1], 0.014f}),
            .cushion = f.material({Pattern::fabric, c.cushion[0], c.cushion[1], 0.018f}),
            .curtain = f.material({Pattern::fabric, c.curtain[0], c.curtain[1], 0.02f}),
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
    shell.materials[north] = f.material({Pattern::wallpaper, palette.colors.wall[0], palette.colors.wall[1], 0.24f});
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
    f.box({0, 0.02f, height / 2}, {0.86f, 0.04f, height},
          f.material({Pattern::panels, palette.colors.door[0], palette.colors.door[1], 0.66f}));
    for (const float side : {-1.0f, 1.0f})
        f.box({side * 0.47f, 0.03f, height / 2}, {0.09f, 0.06f, height}, palette.skirting);
    f.box({0, 0.03f, height + 0.045f}, {1.03f, 0.06f, 0.09f}, palette.skirting);
    f.begin(Part::furniture);
}

void add_dining_group(const Scene& scene, Furniture& f, const Palette& palette, float x, float y)
{
    const auto pile = f.material({Pattern::rug, palette.colors.rug[0], palette.colors.rug[1]});
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

/// What a longer room has more: an armchair on a rug, a second shelf, pictures and a plant.
void add_bay(const Scene& scene, Furniture& f, const Palette& palette, float x)
{
    const float w = scene.size.y;
    const auto pile = f.material({Pattern::rug, palette.colors.rug[1], palette.colors.rug[0]});
    f.stand_at(x, 0.48f * w, -0.1f);
    f.box({0, 0, 0.008f}, {1.7f, 1.2f, 0.016f}, pile).part = Part::floor;
    f.stand_at(x - 0.5f, 0.48f * w, -pi / 2 + 0.5f);
    f.armchair(palette.cloth, palette.cushion);
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
    const auto palette = make_palette(furniture, color_sets[seed % color_sets.size()]);
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

float free_distance(const Scene& scene, Vec3f point)
{
    float distance = 1e9f;
    for (const auto& solid : scene.solids)
        distance = std::min(distance, signed_distance(solid, point));
    return distance;
}

}  // namespace room
