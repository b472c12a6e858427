#include "forked_case.h"
#include "map_figures.h"
#include "plain_uv_map.h"
#include "tables.h"
#include <fresco/rendering/raster_finder.h>

#include <fresco/raycast/ray_finder.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

namespace bench
{
namespace
{

/// Where testing every face takes a second or two.
constexpr int twin_height_px = 12;
constexpr int repeats = 2;
/// Differences of uv are given in texels of such a texture.
constexpr double texture_px = 4096;

struct Implementation
{
    std::string name;
    std::function<std::unique_ptr<fresco::FaceFinder>(const fresco::Mesh&)> finder;
};

const std::vector<Implementation>& implementations()
{
    static const std::vector<Implementation> all{
        {"uvmaps.raster", [](const fresco::Mesh& mesh) { return std::make_unique<fresco::rendering::RasterFinder>(mesh); }},
        {"uvmaps.raycast", [](const fresco::Mesh& mesh) { return std::make_unique<fresco::raycast::RayFinder>(mesh); }}};
    return all;
}

/// Maps need texcoords; which ones costs nothing.
fresco::Mesh with_texcoords(const fresco::Mesh& mesh)
{
    fresco::Mesh result = mesh;
    result.texcoords.clear();
    for (const auto& t : mesh.triangles)
        for (const auto v : t)
            result.texcoords.push_back({mesh.positions[v].x, mesh.positions[v].y});
    return result;
}

std::string listed(const std::vector<int>& heights)
{
    std::string text;
    for (const int height : heights)
        text += (text.empty() ? "" : "+") + std::to_string(height);
    return text;
}

fresco::Value measured(const fresco::Mesh& mesh, const std::vector<fresco::Camera>& cameras, const Implementation& made,
                       const std::vector<int>& heights, int threads, Measure& measure)
{
    std::unique_ptr<fresco::UvMapper> mapper;
    const auto build = measure.times(1, [&] { mapper = std::make_unique<fresco::UvMapper>(mesh, made.finder(mesh)); });
    fresco::PixelCounts all;
    const Threads progress(threads);
    const auto times = measure.times(repeats,
                                     [&]
                                     {
                                         all = {};
                                         for (const auto& camera : cameras)
                                             for (const auto& map : mapper->make(camera, heights, progress))
                                                 all += map.counts;
                                     });
    const auto pixels = static_cast<double>(all.valid + all.back_face + all.too_near + all.crack + all.nothing);
    return fresco::Value::Map{{"build_seconds", build.wall},
                              {"ms_per_frame", 1e3 * times.wall / static_cast<double>(cameras.size())},
                              {"processor_ms_per_frame", 1e3 * times.processor / static_cast<double>(cameras.size())},
                              {"million_pixels_per_second", pixels / times.wall / 1e6},
                              {"valid_share", static_cast<double>(all.valid) / pixels},
                              {"back_share", static_cast<double>(all.back_face) / pixels},
                              {"crack_pixels", all.crack}};
}

/// Of two ways of making the maps of all cameras at one height.
fresco::Value agreed(const fresco::Mesh& mesh, const std::vector<fresco::Camera>& cameras, int height_px)
{
    const auto& made = implementations();
    std::vector<std::unique_ptr<fresco::FaceFinder>> finders;
    std::vector<std::unique_ptr<fresco::UvMapper>> mappers;
    for (const auto& one : made)
    {
        finders.push_back(one.finder(mesh));
        mappers.push_back(std::make_unique<fresco::UvMapper>(mesh, one.finder(mesh)));
    }
    const fresco::Progress one_thread;
    std::size_t pixels = 0;
    std::size_t other_face = 0;
    std::size_t other_validity = 0;
    double uv_apart = 0;
    double depth_apart = 0;
    for (auto camera : cameras)
    {
        const auto& drawn = mappers[0]->make(camera, std::vector<int>{height_px}, one_thread).front().map;
        const auto& cast = mappers[1]->make(camera, std::vector<int>{height_px}, one_thread).front().map;
        camera.intrinsics = camera.intrinsics.scaled_to(drawn.valid.width, height_px);
        std::vector<fresco::FaceMap> faces(2, fresco::FaceMap(drawn.valid.width, height_px));
        for (std::size_t i = 0; i < 2; ++i)
            finders[i]->find(std::span(&camera, 1), one_thread, std::span(faces).subspan(i, 1));
        pixels += faces[0].values.size();
        for (std::size_t i = 0; i < faces[0].values.size(); ++i)
        {
            other_validity += drawn.valid.values[i] != cast.valid.values[i] ? 1 : 0;
            if (faces[0].values[i] != faces[1].values[i])
            {
                ++other_face;
                continue;
            }
            for (const std::size_t k : {2 * i, 2 * i + 1})
                uv_apart = std::max(uv_apart, std::abs(double{drawn.uv.values[k]} - double{cast.uv.values[k]}));
            if (drawn.valid.values[i] != 0 && cast.valid.values[i] != 0)
                depth_apart = std::max(depth_apart, std::abs(double{drawn.depth.values[i]} / double{cast.depth.values[i]} - 1));
        }
    }
    const auto share = [&](std::size_t count) { return static_cast<double>(count) / static_cast<double>(pixels); };
    return fresco::Value::Map{{"pixels", pixels},
                              {"same_face_percent", 100 * (1 - share(other_face))},
                              {"other_validity_share", share(other_validity)},
                              {"texels_apart", texture_px * uv_apart},
                              {"depth_apart", depth_apart}};
}

fresco::Value compared(const fresco::Mesh& mesh, const fresco::Camera& camera, const Implementation& made, Measure& measure)
{
    fresco::UvMapper mapper(mesh, made.finder(mesh));
    fresco::UvMap fast;
    fresco::UvMap plain;
    const fresco::Progress one_thread;
    const std::vector<int> heights{twin_height_px};
    const double plain_seconds = measure.times(1, [&] { plain = plain::uv_map(mesh, camera, twin_height_px); }).processor;
    const double fast_seconds = measure.times(20, [&] { fast = mapper.make(camera, heights, one_thread).front().map; }).processor;
    const auto figures = map_figures(fast, plain);
    const auto pixels = static_cast<double>(figures.pixels);
    return fresco::Value::Map{{"plain_us_per_pixel", 1e6 * plain_seconds / pixels},
                              {"fast_us_per_pixel", 1e6 * fast_seconds / pixels},
                              {"times_faster", ratio(plain_seconds, fast_seconds)},
                              {"pixels", figures.pixels},
                              {"other_validity_share", figures.other_validity_share},
                              {"other_surface_share", figures.other_surface_share},
                              {"largest_uv", figures.largest_uv},
                              {"largest_depth_mm", 1e3 * figures.largest_depth_m},
                              {"largest_cosine", figures.largest_cosine}};
}

/// The mesh itself, and what decimation leaves of it where numbers of faces are asked for.
std::vector<fresco::Mesh> meshes_of(const fresco::Mesh& mesh, const GeometrySettings& settings)
{
    std::vector<fresco::Mesh> result{with_texcoords(mesh)};
    for (const std::size_t faces : settings.faces)
    {
        GeometrySettings one = settings;
        one.faces = {faces};
        if (faces < mesh.triangles.size())
            result.push_back(with_texcoords(simplified(mesh, one)));
    }
    return result;
}

}  // namespace

Table uv_map_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("uv maps", "per frame, each height by itself and all together; the search structure is built once",
                {{"input", "input"},
                 {"implementation", "implementation"},
                 {"faces", "faces"},
                 {"build_seconds", "build s"},
                 {"peak_mb", "peak MB", 0},
                 {"height_px", "height px"},
                 {"threads", "threads"},
                 {"ms_per_frame", "ms/frame", 1},
                 {"processor_ms_per_frame", "cpu ms/frame", 1},
                 {"times_faster", "x one thread", 2},
                 {"million_pixels_per_second", "Mpixels/s"},
                 {"valid_share", "valid", 3},
                 {"crack_pixels", "cracks"}});
    std::vector<std::vector<int>> sizes;
    for (const int height : settings.heights_px)
        sizes.push_back({height});
    if (sizes.size() > 1)
        sizes.push_back(settings.heights_px);
    const auto add =
        [&](const GeometryInput& input, const fresco::Mesh& mesh, const Implementation& made, const std::vector<int>& heights)
    {
        fresco::Value one;
        for (int threads = 1; threads <= settings.threads; threads = threads < settings.threads ? settings.threads : threads + 1)
        {
            auto row = run_case([&](Measure& measure) { return measured(mesh, input.cameras, made, heights, threads, measure); });
            row.set("input", input.name);
            row.set("implementation", made.name);
            row.set("faces", mesh.triangles.size());
            row.set("height_px", listed(heights));
            row.set("threads", threads);
            if (one.is_null())
                one = entry(row, "ms_per_frame");
            row.set("times_faster", ratio(one, entry(row, "ms_per_frame")));
            table.add(std::move(row));
        }
    };
    for (const auto& input : inputs)
        for (const auto& mesh : meshes_of(input.mesh, settings))
            for (const auto& made : implementations())
                for (const auto& heights : sizes)
                    add(input, mesh, made, heights);
    return table;
}

Table uv_map_agreement_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("uv maps, agreement", "uvmaps.raster against uvmaps.raycast, all frames",
                {{"input", "input"},
                 {"faces", "faces"},
                 {"height_px", "height px"},
                 {"pixels", "pixels"},
                 {"same_face_percent", "same face %", 5},
                 {"other_validity_share", "other validity", 6},
                 {"texels_apart", "texels apart", 4},
                 {"depth_apart", "depth apart", 7}});
    for (const auto& input : inputs)
        for (const auto& mesh : meshes_of(input.mesh, settings))
            for (const int height : settings.heights_px)
            {
                auto row = run_case([&](Measure&) { return agreed(mesh, input.cameras, height); });
                row.set("input", input.name);
                row.set("faces", mesh.triangles.size());
                row.set("height_px", height);
                table.add(std::move(row));
            }
    return table;
}

Table uv_map_twin_table(const std::vector<GeometryInput>& inputs, const GeometrySettings&)
{
    Table table("uv maps, twin", "against a test of every face for every pixel of a tiny map",
                {{"input", "input"},
                 {"implementation", "implementation"},
                 {"faces", "faces"},
                 {"pixels", "pixels"},
                 {"plain_us_per_pixel", "plain cpu us/pixel", 1},
                 {"fast_us_per_pixel", "cpu us/pixel"},
                 {"times_faster", "x faster", 0},
                 {"other_validity_share", "other validity", 4},
                 {"other_surface_share", "other surface", 4},
                 {"largest_uv", "uv apart", 7},
                 {"largest_depth_mm", "depth apart mm", 5},
                 {"largest_cosine", "cosine apart", 6}});
    for (const auto& input : inputs)
    {
        const auto mesh = with_texcoords(input.mesh);
        for (const auto& made : implementations())
        {
            auto row = run_case([&](Measure& measure) { return compared(mesh, input.cameras.front(), made, measure); });
            row.set("input", input.name);
            row.set("implementation", made.name);
            row.set("faces", mesh.triangles.size());
            table.add(std::move(row));
        }
    }
    return table;
}

}  // namespace bench
