#include "atlases.h"
#include "forked_case.h"
#include "mix.h"
#include "tables.h"

#include <fresco/random.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <cmath>

namespace bench
{
namespace
{

using namespace fresco;

constexpr double split_m = 0.2;
constexpr MixShares shares{0.4, 0.8};
constexpr int repeats = 2;

struct Textures
{
    Mesh mesh;
    texturing::TexelFaces faces;
    RasterF photo, painted;
};

RasterF noise(int size, std::uint64_t seed)
{
    RasterF result(size, size, 3);
    Random random(seed);
    for (float& value : result.values)
        value = static_cast<float>(random.uniform());
    return result;
}

/// The mean looked up for every texel by itself, and the pictures mixed afterwards.
RasterF plainly_mixed(const Textures& in)
{
    const auto normals = vertex_normals(in.mesh);
    const auto box = [&](auto better)
    {
        Vec3f result = in.mesh.positions.front();
        for (const Vec3f& p : in.mesh.positions)
            result = {better(result.x, p.x), better(result.y, p.y), better(result.z, p.z)};
        return result;
    };
    SurfaceAverage average(box([](float a, float b) { return std::min(a, b); }),
                           box([](float a, float b) { return std::max(a, b); }), split_m);
    const auto value = [](const RasterF& from, std::size_t texel) {
        return Vec3f{from.values[3 * texel], from.values[3 * texel + 1], from.values[3 * texel + 2]};
    };
    const auto normal = [&](std::size_t texel)
    {
        const auto weights = texturing::texel_weights(in.mesh, in.faces, texel);
        Vec3f sum;
        for (std::size_t i = 0; i < 3; ++i)
            sum += normals[in.mesh.triangles[in.faces.face[texel]][i]] * static_cast<float>(weights[i]);
        return normalized(sum);
    };
    for (std::size_t texel = 0; texel < in.faces.face.size(); ++texel)
        if (in.faces.inside[texel] != 0)
            average.add(texel_position(in.mesh, in.faces, texel), normal(texel),
                        value(in.painted, texel) - value(in.photo, texel));
    SurfaceAverage::Lookup lookup(average);
    RasterF result = in.photo;
    for (std::size_t texel = 0; texel < in.faces.face.size(); ++texel)
    {
        const Vec3f photo = value(in.photo, texel);
        Vec3f tone = photo;
        if (in.faces.covered(texel))
            tone += lookup.at(texel_position(in.mesh, in.faces, texel), normal(texel), value(in.painted, texel) - photo);
        const Vec3f mixed = photo + (tone - photo) * static_cast<float>(shares.color) +
                            (value(in.painted, texel) - tone) * static_cast<float>(shares.strokes);
        result.values[3 * texel] = std::clamp(mixed.x, 0.0F, 1.0F);
        result.values[3 * texel + 1] = std::clamp(mixed.y, 0.0F, 1.0F);
        result.values[3 * texel + 2] = std::clamp(mixed.z, 0.0F, 1.0F);
    }
    return result;
}

Value measured(const Textures& in, int threads, Measure& measure)
{
    const Threads progress(threads);
    Mix fast;
    RasterF plain;
    const auto fast_times =
        measure.times(repeats, [&] { fast = mix(in.photo, in.painted, in.mesh, in.faces, split_m, shares, progress); });
    const auto plain_times = measure.times(1, [&] { plain = plainly_mixed(in); });
    double sum = 0;
    for (std::size_t i = 0; i < plain.values.size(); ++i)
        sum += std::abs(255 * (double{plain.values[i]} - double{fast.rgb.values[i]}));
    return Value::Map{{"seconds", fast_times.wall},
                      {"processor_seconds", fast_times.processor},
                      {"plain_processor_seconds", plain_times.processor},
                      {"times_as_fast", ratio(plain_times.processor, fast_times.processor)},
                      {"apart", sum / static_cast<double>(plain.values.size())}};
}
}  // namespace

Table mix_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("mix", "noise in two textures of size_px mixed by texture.mix, and texel by texel",
                {{"input", "input"},
                 {"seconds", "s"},
                 {"processor_seconds", "cpu s"},
                 {"plain_processor_seconds", "texel by texel, cpu s"},
                 {"times_as_fast", "x texel by texel (cpu)", 1},
                 {"apart", "apart, steps", 4}});
    for (const auto& input : inputs)
    {
        auto row = run_case(
            [&](Measure& measure)
            {
                const Threads progress(settings.threads);
                Textures in;
                Threads atlas_progress(settings.threads);
                in.mesh = atlas_makers().front().run(simplified(input.mesh, settings), settings.size_px, atlas_progress);
                in.faces = texturing::find_texel_faces(in.mesh, texturing::find_charts(in.mesh), settings.size_px, progress);
                in.photo = noise(settings.size_px, 1);
                in.painted = noise(settings.size_px, 2);
                return measured(in, settings.threads, measure);
            });
        row.set("input", input.name);
        table.add(std::move(row));
    }
    return table;
}

}  // namespace bench
