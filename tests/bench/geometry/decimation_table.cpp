#include "decimate.h"
#include "forked_case.h"
#include "repair.h"
#include "surface_figures.h"
#include "tables.h"
#include "vertex_clustering.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace bench
{
namespace
{

constexpr std::uint64_t seed = 1;

std::size_t target_of(const fresco::Mesh& mesh, const GeometrySettings& settings)
{
    return std::max<std::size_t>(static_cast<std::size_t>(static_cast<double>(mesh.triangles.size()) * settings.keep), 4);
}

fresco::Mesh quadric(const fresco::Mesh& mesh, std::size_t target)
{
    fresco::Progress progress;
    RepairReport report;
    return decimated(repaired(mesh, report, progress), {.max_faces = target}, progress);
}

struct Decimation
{
    const char* name;
    std::function<fresco::Mesh(const fresco::Mesh&, std::size_t)> run;
};

/// The first is what the others' times are compared with.
const std::vector<Decimation>& decimations()
{
    static const std::vector<Decimation> all{{"mesh.decimate", quadric}, {"vertex clustering", clustered}};
    return all;
}

fresco::Value measured(const Decimation& decimation, const GeometryInput& input, const GeometrySettings& settings,
                       Measure& measure)
{
    fresco::Mesh result;
    const auto times = measure.times(1, [&] { result = decimation.run(input.mesh, target_of(input.mesh, settings)); });
    const auto distance = surface_distance(result, input.mesh, settings.samples, seed, settings.threads).both();
    const auto border = border_distance(result, input.mesh, settings.samples, seed, settings.threads).both();
    const auto faults = face_faults(result, input.mesh, settings.threads);
    return fresco::Value::Map{{"seconds", times.wall},
                              {"processor_seconds", times.processor},
                              {"faces_after", result.triangles.size()},
                              {"distance_mean_mm", figure(1e3 * distance.mean)},
                              {"distance_p99_mm", figure(1e3 * distance.p99)},
                              {"distance_largest_mm", figure(1e3 * distance.largest)},
                              {"border_mean_mm", figure(1e3 * border.mean)},
                              {"border_p99_mm", figure(1e3 * border.p99)},
                              {"flipped_faces", faults.flipped},
                              {"degenerate_faces", faults.degenerate},
                              {"non_manifold_edges_created", faults.non_manifold_edges_created}};
}

}  // namespace

fresco::Mesh simplified(const fresco::Mesh& mesh, const GeometrySettings& settings)
{
    return quadric(mesh, target_of(mesh, settings));
}

Table decimation_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("decimation", "simplified to a share of the faces; how near the result is to its input",
                {{"input", "input"},
                 {"implementation", "implementation"},
                 {"faces", "faces"},
                 {"faces_after", "left"},
                 {"seconds", "s"},
                 {"processor_seconds", "cpu s"},
                 {"times_as_long", "x first (cpu)", 3},
                 {"peak_mb", "peak MB", 0},
                 {"distance_mean_mm", "mean mm", 3},
                 {"distance_p99_mm", "p99 mm", 3},
                 {"border_mean_mm", "border mean mm", 3},
                 {"border_p99_mm", "border p99 mm", 3},
                 {"flipped_faces", "flipped"},
                 {"degenerate_faces", "flat"},
                 {"non_manifold_edges_created", "non-manifold"}});
    for (const auto& input : inputs)
    {
        fresco::Value first;
        for (const auto& decimation : decimations())
        {
            auto row = run_case([&](Measure& measure) { return measured(decimation, input, settings, measure); });
            row.set("input", input.name);
            row.set("implementation", decimation.name);
            row.set("faces", input.mesh.triangles.size());
            if (first.is_null())
                first = entry(row, "processor_seconds");
            row.set("times_as_long", ratio(entry(row, "processor_seconds"), first));
            table.add(std::move(row));
        }
    }
    return table;
}

}  // namespace bench
