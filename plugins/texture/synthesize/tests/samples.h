#pragma once

#include "catch.h"
#include "synthesis.h"
#include <fresco/testing_scenes.h>

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/random.h>
#include <fresco/stage.h>
#include <fresco/testing.h>
#include <fresco/texture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>

/// \file Surfaces and pictures that are known by hand.

namespace samples
{

using namespace fresco;
using namespace fresco::synthesize;

using testing::append;

/// A flat rectangle of quads x quads whose chart is turned about `middle`, with `uv_per_m` texcoords along a meter.
inline Mesh rectangle(Vec3f corner, Vec3f across, Vec3f along, Vec2f middle, float uv_per_m, double turn = 0, int quads = 1)
{
    const auto c = static_cast<float>(std::cos(turn)) * uv_per_m;
    const auto s = static_cast<float>(std::sin(turn)) * uv_per_m;
    const auto count = static_cast<std::uint32_t>(quads);
    Mesh chart = testing::rectangle(corner, across, along, count, count);
    const Vec2f step = Vec2f{length(across), length(along)} * (1 / static_cast<float>(quads));
    for (const Triangle& t : chart.triangles)
        for (const std::uint32_t v : t)
        {
            const float x = step.x * (static_cast<float>(v % (count + 1)) - static_cast<float>(quads) / 2);
            const float y = step.y * (static_cast<float>(v / (count + 1)) - static_cast<float>(quads) / 2);
            chart.texcoords.push_back(middle + Vec2f{c * x - s * y, s * x + c * y});
        }
    return chart;
}

/// A wall of 2 m x 1 m in the plane z = 0, facing +z, in two charts that join at x = 1 and are turned in the atlas: the left one
/// by `turn`, the right one by half a turn more.
inline Mesh turned_wall(double turn, int quads)
{
    Mesh mesh;
    append(mesh, rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.25F}, 0.3F, turn, quads));
    append(mesh, rectangle({1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.75F, 0.25F}, 0.3F, turn + std::numbers::pi, quads));
    return mesh;
}

/// Two squares of 1 m that join at the x axis: the first in the plane z = 0, the second bent out of it by `bend` radians.
inline Mesh bent_floor(double bend, int quads)
{
    Mesh mesh;
    const Vec3f up{0, static_cast<float>(std::cos(bend)), static_cast<float>(std::sin(bend))};
    append(mesh, rectangle({0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.25F}, 0.3F, 0, quads));
    append(mesh, rectangle({0, 0, 0}, {1, 0, 0}, up, {0.75F, 0.25F}, 0.3F, 0, quads));
    return mesh;
}

/// A mesh, ready to lay patches on.
struct Prepared
{
    Prepared(const Mesh& of, double spacing_m, Vec3f up = {0, 1, 0})
        : mesh(of), surface(mesh, run), upward(upright(surface, up)), grid(surface, spacing_m, run)
    {
    }

    testing::TestRun run;
    Mesh mesh;
    PaintedSurface surface;
    Upright upward;
    SurfaceGrid grid;
};

/// Soft strokes of `width_px`, lying mostly along x, dark blue at the top to bright yellow at the bottom.
inline Raster8 brush_picture(int width, int height, std::uint64_t seed, double width_px = 6)
{
    Random random(seed);
    RasterF canvas(width, height, 3, 120);
    const int strokes = static_cast<int>(width * height / (width_px * width_px) * 1.5);
    for (int i = 0; i < strokes; ++i)
    {
        const double cx = random.uniform() * width;
        const double cy = random.uniform() * height;
        const double angle = 0.5 * random.normal();
        const double share = cy / height;
        const double light = 30 * random.normal();
        const std::array<double, 3> color{40 + 190 * share + light, 60 + 130 * share + light, 120 - 40 * share + light};
        const int reach = static_cast<int>(3 * width_px);
        for (int y = static_cast<int>(cy) - reach; y <= static_cast<int>(cy) + reach; ++y)
            for (int x = static_cast<int>(cx) - reach; x <= static_cast<int>(cx) + reach; ++x)
            {
                if (x < 0 || y < 0 || x >= width || y >= height)
                    continue;
                const double along = (x - cx) * std::cos(angle) + (y - cy) * std::sin(angle);
                const double across = (y - cy) * std::cos(angle) - (x - cx) * std::sin(angle);
                const double inside = std::min(1.25 * width_px - std::abs(along), width_px / 2 - std::abs(across)) + 0.5;
                const auto cover = static_cast<float>(std::clamp(inside, 0.0, 1.0));
                for (int c = 0; c < 3; ++c)
                    canvas.at(x, y, c) += cover * (static_cast<float>(color[static_cast<std::size_t>(c)]) - canvas.at(x, y, c));
            }
    }
    Raster8 result(width, height, 3);
    for (std::size_t i = 0; i < canvas.values.size(); ++i)
        result.values[i] = static_cast<std::uint8_t>(std::clamp(canvas.values[i] + 0.5F, 0.0F, 255.0F));
    return result;
}

/// The start of a wall's painting, in the texcoords of its charts.
using Start = std::function<Vec3f(std::uint32_t chart, Vec2f uv)>;

/// Inputs of the algorithms: a wall whose charts are turned in the atlas, so that no point of a patch lies at a texel's center
/// by chance.
struct WallTask
{
    explicit WallTask(Start of, int quads = 1) : start(std::move(of)), mesh(turned_wall(0.4, quads)) {}

    Start start;
    testing::TestRun run;
    Mesh mesh;
    PaintedSurface surface{mesh, run};
    Upright upward = upright(surface, Vec3f{0, 1, 0});
    Raster8 picture = brush_picture(56, 48, 11);
    Task task{surface, upward, picture, [this](std::uint32_t chart, Vec2f uv, double) { return start(chart, uv); }};
};

/// Smooth colors, another one in each chart.
inline Vec3f smooth_start(std::uint32_t chart, Vec2f uv)
{
    return {0.3F + 0.5F * uv.x, 0.4F + 0.1F * static_cast<float>(chart), 0.6F - 0.4F * uv.y};
}

/// A plain left half and a right half with stripes of 14 cm, half a stroke, that run up the wall.
inline Start striped(float contrast)
{
    return [contrast](std::uint32_t chart, Vec2f uv)
    {
        const double along = static_cast<double>(uv.x) * std::cos(0.4) + static_cast<double>(uv.y) * std::sin(0.4);
        const auto wave = static_cast<float>(std::sin(2 * std::numbers::pi * along / 0.3 / 0.14));
        return Vec3f{0.5F, 0.5F, 0.4F} + Vec3f{1, 1, 1} * (chart == 1 ? contrast * wave : 0);
    };
}

inline Vec3f color_at(const Texture& texture, int x, int y)
{
    const float* rgb = &texture.layers.front().at(x, y);
    return {rgb[0], rgb[1], rgb[2]};
}

/// The center of a texel.
inline Vec2f texcoord(int size, int x, int y)
{
    return {(static_cast<float>(x) + 0.5F) / static_cast<float>(size),
            1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(size)};
}

}  // namespace samples

/// \file Painting a small wall with the built plugin.

namespace studio
{

using namespace samples;

/// All texels known, by their texcoords.
inline Texture start_of(const Mesh& mesh, int size, const std::function<Vec3f(Vec2f)>& rgb)
{
    Texture texture = testing::blank_texture(size, 0);
    texture.atlas = atlas_id(mesh);
    texture.seen = Raster8(size, size, 1, 1);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const Vec3f color = rgb(texcoord(size, x, y));
            std::ranges::copy(std::array{color.x, color.y, color.z}, &texture.layers.front().at(x, y));
        }
    return texture;
}

struct Painted
{
    std::shared_ptr<Texture> texture;
    std::shared_ptr<SourceMap> source;
    std::vector<std::vector<std::byte>> bytes;
    Value reported;
};

/// The wall of two charts with a smooth start, and what to change about it.
struct Studio
{
    Mesh mesh = testing::two_chart_wall();
    Texture start = start_of(mesh, 96, [](Vec2f uv) { return Vec3f{0.2F + 0.5F * uv.x, 0.3F + uv.y, 0.6F - uv.y}; });
    Raster8 picture = brush_picture(96, 80, 21);
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Texture> lines;

    /// With strokes of 16 cm, all of one width; levels of 4 and 2 cm a texel.
    Painted paint(const Value::Map& options = {}, int threads = 2) const
    {
        testing::TestRun run(threads);
        testing::TemporaryFolder out;
        testing::Inputs inputs{{"mesh", std::make_shared<Mesh>(mesh)},
                               {"start", std::make_shared<Texture>(start)},
                               {"style", std::make_shared<Image>(picture)}};
        if (frames)
            inputs["frames"] = frames;
        if (lines)
            inputs["lines"] = lines;
        Value given = Value::Map{{"size_px", 128},   {"stroke_cm", 16.0}, {"rounds_count", 3},
                                 {"painterly", 0.5}, {"detail", 0.0},     {"up", "z"}};
        for (const auto& [name, value] : options)
            given.set(name, value);
        testing::run_stage(FRESCO_PLUGIN_FILE, "texture.synthesize", given, inputs, out.path(), run);
        Painted result;
        for (const char* file : {"texture/layer_0.packed", "texture/seen.packed", "texture/texture.json", "source/places.packed",
                                 "source/shifts.packed", "source/source_map.json"})
            result.bytes.push_back(read_file(out.path() / file));
        result.texture = Texture::load({out.path() / "texture", out.path()});
        result.source = SourceMap::load({out.path() / "source", out.path()});
        result.reported = run.reported;
        return result;
    }
};

inline float luminance(Vec3f rgb)
{
    return 0.3F * rgb.x + 0.6F * rgb.y + 0.1F * rgb.z;
}

/// Position of a texel on the wall of two charts, to the right and up, in meters; negative off the
/// charts.
inline Vec2d on_wall(int size, int x, int y)
{
    const double u = (x + 0.5) / size;
    const double v = 1 - (y + 0.5) / size;
    const auto inside = [](double from, double at) { return at > from && at < from + 0.3; };
    if (!inside(0.1, v) || (!inside(0.1, u) && !inside(0.6, u)))
        return {-1, -1};
    return u < 0.5 ? Vec2d{(u - 0.1) / 0.3, (v - 0.1) / 0.3} : Vec2d{1 + (0.9 - u) / 0.3, (0.4 - v) / 0.3};
}

}  // namespace studio
