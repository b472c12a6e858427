#include "forked_case.h"
#include "map_figures.h"
#include "plain_uv_maps.h"
#include "tables.h"
#include "uv_map_caster.h"

#include <algorithm>
#include <memory>

namespace bench
{
namespace
{

/// Where testing every face takes a second or two.
constexpr int twin_height_px = 12;
constexpr int repeats = 2;

/// Casting needs texcoords; their values cost nothing.
fresco::Mesh with_texcoords(const fresco::Mesh& mesh)
{
    fresco::Mesh result = mesh;
    result.texcoords.clear();
    for (const auto& t : mesh.triangles)
        for (const auto v : t)
            result.texcoords.push_back({mesh.positions[v].x, mesh.positions[v].y});
    return result;
}

fresco::Value measured(const fresco::Mesh& mesh, const std::vector<fresco::Camera>& cameras, int height_px, int threads,
                       Measure& measure)
{
    std::unique_ptr<UvMapCaster> caster;
    const auto build = measure.times(1, [&] { caster = std::make_unique<UvMapCaster>(mesh); });
    PixelCounts all;
    const Threads progress(threads);
    const auto times = measure.times(repeats,
                                     [&]
                                     {
                                         all = {};
                                         for (const auto& camera : cameras)
                                         {
                                             PixelCounts counts;
                                             caster->cast(camera, height_px, progress, counts);
                                             all += counts;
                                         }
                                     });
    const auto pixels = static_cast<double>(all.valid + all.back_face + all.too_near + all.nothing);
    return fresco::Value::Map{{"build_seconds", build.wall},
                              {"ms_per_frame", 1e3 * times.wall / static_cast<double>(cameras.size())},
                              {"processor_ms_per_frame", 1e3 * times.processor / static_cast<double>(cameras.size())},
                              {"million_rays_per_second", pixels / times.wall / 1e6},
                              {"valid_share", static_cast<double>(all.valid) / pixels}};
}

fresco::Value compared(const fresco::Mesh& mesh, const fresco::Camera& camera, Measure& measure)
{
    const UvMapCaster caster(mesh);
    fresco::UvMap fast;
    fresco::UvMap plain;
    PixelCounts counts;
    const fresco::Progress one_thread;
    const double plain_seconds = measure.times(1, [&] { plain = plain_uv_map(mesh, camera, twin_height_px); }).processor;
    const double fast_seconds =
        measure.times(20, [&] { fast = caster.cast(camera, twin_height_px, one_thread, counts); }).processor;
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

}  // namespace

Table uv_map_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("uv maps", "uvmaps.raycast, per frame; the search structure is built once",
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
                 {"million_rays_per_second", "Mrays/s"},
                 {"valid_share", "valid", 3}});
    for (const auto& input : inputs)
    {
        const auto mesh = with_texcoords(input.mesh);
        for (const int height : settings.heights_px)
        {
            fresco::Value one;
            for (int threads = 1; threads <= settings.threads;
                 threads = threads < settings.threads ? settings.threads : threads + 1)
            {
                auto row = run_case([&](Measure& measure) { return measured(mesh, input.cameras, height, threads, measure); });
                row.set("input", input.name);
                row.set("implementation", "uvmaps.raycast");
                row.set("faces", mesh.triangles.size());
                row.set("height_px", height);
                row.set("threads", threads);
                if (one.is_null())
                    one = entry(row, "ms_per_frame");
                row.set("times_faster", ratio(one, entry(row, "ms_per_frame")));
                table.add(std::move(row));
            }
        }
    }
    return table;
}

Table uv_map_twin_table(const std::vector<GeometryInput>& inputs, const GeometrySettings&)
{
    Table table("uv maps, twin", "uvmaps.raycast and a test of every face against every pixel give the same tiny map",
                {{"input", "input"},
                 {"faces", "faces"},
                 {"pixels", "pixels"},
                 {"plain_us_per_pixel", "plain cpu us/pixel", 1},
                 {"fast_us_per_pixel", "raycast cpu us/pixel"},
                 {"times_faster", "x faster", 0},
                 {"other_validity_share", "other validity", 4},
                 {"other_surface_share", "other surface", 4},
                 {"largest_uv", "uv apart", 7},
                 {"largest_depth_mm", "depth apart mm", 5},
                 {"largest_cosine", "cosine apart", 6}});
    for (const auto& input : inputs)
    {
        const auto mesh = with_texcoords(input.mesh);
        auto row = run_case([&](Measure& measure) { return compared(mesh, input.cameras.front(), measure); });
        row.set("input", input.name);
        row.set("faces", mesh.triangles.size());
        table.add(std::move(row));
    }
    return table;
}

}  // namespace bench
