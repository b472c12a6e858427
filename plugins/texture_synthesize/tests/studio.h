#pragma once

#include "catch.h"
#include "samples.h"
#include "stored_png.h"
#include "two_chart_wall.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/source_map.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <functional>
#include <memory>
#include <string>

/// \file Painting a small wall with the built plugin.

namespace studio
{

using namespace samples;

/// All texels known, by their texcoords.
inline Texture start_of(const Mesh& mesh, int size, const std::function<Vec3f(Vec2f)>& rgb)
{
    Texture texture = blank_texture(size, 0);
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
    Mesh mesh = two_chart_wall();
    Texture start = start_of(mesh, 96, [](Vec2f uv) { return Vec3f{0.2F + 0.5F * uv.x, 0.3F + uv.y, 0.6F - uv.y}; });
    Raster8 picture = brush_picture(96, 80, 21);
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Texture> lines;

    /// Strokes of 16 cm; levels of 4 and 2 cm a texel. Small patches: fast.
    static Value options(Value::Map more = {})
    {
        Value result = Value::Map{{"size_px", 128}, {"stroke_cm", 16.0}, {"patch_px", 7}, {"rounds_count", 3}};
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
        testing::run_stage(FRESCO_PLUGIN_FILE, "texture.synthesize", options, inputs, out.path(), run,
                           {{"images", std::make_shared<stored_png::Codec>()}});
        Painted result;
        for (const char* file :
             {"texture/layer_0.npy", "texture/seen.npy", "texture/texture.json", "source/places.npy", "source/source_map.json"})
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

/// Of a texture's texel: how far to the right on the wall of two charts it is, and how far up, in meters; negative off the
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
