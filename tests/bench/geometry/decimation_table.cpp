#include "decimate.h"
#include "decimations.h"
#include "forked_case.h"
#include "surface_figures.h"
#include "tables.h"

#include <fresco/geometry/repair.h>

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
    if (!settings.faces.empty())
        return settings.faces.back();
    return std::max<std::size_t>(static_cast<std::size_t>(static_cast<double>(mesh.triangles.size()) * settings.keep), 4);
}

fresco::Mesh repaired_alone(const fresco::Mesh& mesh, fresco::Progress& progress)
{
    fresco::geometry::RepairReport report;
    return fresco::geometry::repaired(mesh, report, progress);
}

fresco::Value measured(const Decimation& decimation, const GeometryInput& input, std::size_t target,
                       const GeometrySettings& settings, Measure& measure)
{
    // All begin from the same manifold. Only mesh.decimate's own time includes making it: the stage does it.
    Threads progress(settings.threads);
    const fresco::Mesh manifold = repaired_alone(input.mesh, progress);
    const bool ours = &decimation == decimations().data();
    fresco::Mesh result;
    const auto times = measure.times(settings.repeats,
                                     [&]
                                     {
                                         result = ours ? decimation.run(repaired_alone(input.mesh, progress), target, progress)
                                                       : decimation.run(manifold, target, progress);
                                     });
    const auto distance = surface_distance(result, input.mesh, settings.samples, seed, settings.threads).both();
    const auto border = border_distance(result, input.mesh, settings.samples, seed, settings.threads).both();
    const auto faults = face_faults(result, input.mesh, settings.threads);
    const auto& own = decimation.own_seconds;
    return fresco::Value::Map{{"seconds", own ? own() : times.wall},
                              {"processor_seconds", own ? fresco::Value() : fresco::Value(times.processor)},
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
    Threads progress(settings.threads);
    return decimated(repaired_alone(mesh, progress), {.max_faces = target_of(mesh, settings)}, progress);
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
                 {"times_as_long", "x first", 2},
                 {"peak_mb", "peak MB", 0},
                 {"distance_mean_mm", "mean mm", 3},
                 {"distance_p99_mm", "p99 mm", 3},
                 {"border_mean_mm", "border mean mm", 3},
                 {"border_p99_mm", "border p99 mm", 3},
                 {"flipped_faces", "flipped"},
                 {"degenerate_faces", "flat"},
                 {"non_manifold_edges_created", "non-manifold"}});
    for (const auto& input : inputs)
        for (const std::size_t target : settings.faces.empty() ? std::vector{target_of(input.mesh, settings)} : settings.faces)
        {
            if (target >= input.mesh.triangles.size())
                continue;
            fresco::Value first;
            for (const auto& decimation : decimations())
            {
                auto row = run_case([&](Measure& measure) { return measured(decimation, input, target, settings, measure); });
                row.set("input", input.name);
                row.set("implementation", decimation.name);
                row.set("faces", input.mesh.triangles.size());
                if (first.is_null())
                    first = entry(row, "seconds");
                row.set("times_as_long", ratio(entry(row, "seconds"), first));
                table.add(std::move(row));
            }
        }
    return table;
}

}  // namespace bench
