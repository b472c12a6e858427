#pragma once

#include "catch.h"
#include "patches.h"
#include "stage.h"
#include "stored_png.h"
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

/// A flat rectangle of columns x rows quads with vertices of its own, and where it lies in the atlas.
struct Rectangle
{
    Vec3f corner, across, along;
    Vec2f uv_corner, uv_across, uv_along;
    int columns = 1;
    int rows = 1;
};

/// Makes a rectangle whose chart is turned about `middle`, with `uv_per_m` texcoords along a meter.
inline Rectangle rectangle(Vec3f corner, Vec3f across, Vec3f along, Vec2f middle, float uv_per_m, double turn = 0, int quads = 1)
{
    const auto c = static_cast<float>(std::cos(turn)) * uv_per_m;
    const auto s = static_cast<float>(std::sin(turn)) * uv_per_m;
    const Vec2f u = Vec2f{c, s} * length(across);
    const Vec2f v = Vec2f{-s, c} * length(along);
    return {corner, across, along, middle - (u + v) * 0.5F, u, v, quads, quads};
}

inline void add(Mesh& mesh, const Rectangle& r)
{
    const auto columns = static_cast<std::uint32_t>(r.columns), rows = static_cast<std::uint32_t>(r.rows);
    Mesh chart = testing::rectangle(r.corner, r.across, r.along, columns, rows);
    const auto share = [](std::uint32_t i, std::uint32_t count) { return static_cast<float>(i) / static_cast<float>(count); };
    for (const Triangle& t : chart.triangles)
        for (const std::uint32_t v : t)
            chart.texcoords.push_back(r.uv_corner + r.uv_across * share(v % (columns + 1), columns) +
                                      r.uv_along * share(v / (columns + 1), rows));
    testing::append(mesh, chart);
}

/// A wall of 2 m x 1 m in the plane z = 0, facing +z, in two charts that join at x = 1 and are turned in the atlas: the left one
/// by `turn`, the right one by half a turn more.
inline Mesh turned_wall(double turn, int quads)
{
    Mesh mesh;
    add(mesh, rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.25F}, 0.3F, turn, quads));
    add(mesh, rectangle({1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.75F, 0.25F}, 0.3F, turn + std::numbers::pi, quads));
    return mesh;
}

/// Two squares of 1 m that join at the x axis: the first in the plane z = 0, the second bent out of it by `bend` radians.
inline Mesh bent_floor(double bend, int quads)
{
    Mesh mesh;
    const Vec3f up{0, static_cast<float>(std::cos(bend)), static_cast<float>(std::sin(bend))};
    add(mesh, rectangle({0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.25F}, 0.3F, 0, quads));
    add(mesh, rectangle({0, 0, 0}, {1, 0, 0}, up, {0.75F, 0.25F}, 0.3F, 0, quads));
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
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const auto at = [size](int i) { return (static_cast<float>(i) + 0.5F) / static_cast<float>(size); };
            const Vec3f color = rgb({at(x), 1 - at(y)});
            texture.layers.front().at(x, y, 0) = color.x;
            texture.layers.front().at(x, y, 1) = color.y;
            texture.layers.front().at(x, y, 2) = color.z;
            texture.seen.at(x, y) = 1;
        }
    return texture;
}

struct Painted
{
    std::shared_ptr<Texture> texture;
    std::shared_ptr<SourceMap> source;
    std::vector<std::vector<std::byte>> bytes;
};

/// The wall of two charts with a smooth start, and what to change about it.
struct Studio
{
    Mesh mesh = testing::two_chart_wall();
    Texture start = start_of(mesh, 96, [](Vec2f uv) { return Vec3f{0.2F + 0.5F * uv.x, 0.3F + uv.y, 0.6F - uv.y}; });
    Raster8 picture = brush_picture(96, 80, 21);
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Texture> lines;

    /// Strokes of 16 cm, all of one width; levels of 4 and 2 cm a texel. Small patches: fast; they, and the seconds between
    /// checkpoints and previews, are no options of the stage.
    static Value options(Value::Map more = {})
    {
        Value result = Value::Map{{"size_px", 128},   {"stroke_cm", 16.0}, {"patch_px", 7}, {"rounds_count", 3},
                                  {"painterly", 0.5}, {"detail", 0.0},     {"up", "z"}};
        for (auto& [name, value] : more)
            result.set(name, value);
        return result;
    }

    Painted paint(testing::TestRun& run, const Value& options) const
    {
        testing::TemporaryFolder out;
        testing::Inputs inputs{{"mesh", std::make_shared<Mesh>(mesh)},
                               {"start", std::make_shared<Texture>(start)},
                               {"style", std::make_shared<Image>(picture)}};
        if (frames)
            inputs["frames"] = frames;
        if (lines)
            inputs["lines"] = lines;
        synthesize::TextureSynthesize stage;
        Value given = Value::Map{{"image_io", Value::Map{{"type", "test.codec"}}}};
        for (const auto& [name, value] : options.as_map())
            if (name == "patch_px")
                stage.fixed.patch_px = static_cast<int>(value.as_int());
            else if (name == "checkpoint_seconds")
                stage.fixed.checkpoint_seconds = value.as_double();
            else if (name == "preview_seconds")
                stage.fixed.preview_seconds = value.as_double();
            else
                given.set(name, value);
        testing::TestFactory factory;
        factory.add("test.codec", [] { return std::make_shared<stored_png::Codec>(); });
        testing::run_stage(stage, given, inputs, out.path(), run, factory);
        Painted result;
        for (const char* file : {"texture/layer_0.packed", "texture/seen.packed", "texture/texture.json", "source/places.packed",
                                 "source/shifts.packed", "source/source_map.json"})
            result.bytes.push_back(read_file(out.path() / file));
        result.texture = Texture::load({out.path() / "texture", out.path()});
        result.source = SourceMap::load({out.path() / "source", out.path()});
        return result;
    }

    Painted paint(Value::Map more = {}) const
    {
        testing::TestRun run;
        return paint(run, options(std::move(more)));
    }
};

inline Vec3f color_at(const Texture& texture, int x, int y)
{
    const float* rgb = &texture.layers.front().at(x, y);
    return {rgb[0], rgb[1], rgb[2]};
}

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
