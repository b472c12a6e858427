#include "atlases.h"
#include "forked_case.h"
#include "tables.h"

#include <fresco/geometry/atlas_figures.h>

namespace bench
{
namespace
{

fresco::Value measured(const AtlasMaker& maker, const fresco::Mesh& mesh, const GeometrySettings& settings, Measure& measure)
{
    fresco::Mesh result;
    Threads progress(settings.threads);
    const auto times = measure.times(1, [&] { result = maker.run(mesh, settings.size_px, progress); });
    const auto figures = fresco::geometry::atlas_figures(result, settings.size_px);
    const auto& own = maker.own_seconds;
    return fresco::Value::Map{{"seconds", own ? own() : times.wall},
                              {"processor_seconds", own ? fresco::Value() : fresco::Value(times.processor)},
                              {"charts", figures.charts},
                              {"used_share", figures.used_share},
                              {"texels_per_cm", figures.texels_per_cm},
                              {"stretch_l2", figure(figures.stretch_l2)},
                              {"stretch_linf", figure(figures.stretch_linf)},
                              {"density_variation", figure(figures.density_variation)},
                              {"squeezed_share", figures.squeezed_share},
                              {"lost_faces", figures.lost_faces},
                              {"seam_length_m", figures.seam_length_m},
                              {"seam_length_share", figures.seam_length_share},
                              {"overlapping_texels", fresco::geometry::overlapping_texels(result, settings.size_px)},
                              {"outside_corners", figures.outside_corners}};
}

void add_rows(Table& table, const std::string& name, const fresco::Mesh& mesh, std::size_t makers,
              const GeometrySettings& settings)
{
    fresco::Value first;
    for (std::size_t i = 0; i < makers; ++i)
    {
        const auto& maker = atlas_makers()[i];
        auto row = run_case([&](Measure& measure) { return measured(maker, mesh, settings, measure); });
        row.set("input", name);
        row.set("implementation", maker.name);
        row.set("faces", mesh.triangles.size());
        if (first.is_null())
            first = entry(row, "processor_seconds");
        row.set("times_as_long", ratio(entry(row, "processor_seconds"), first));
        table.add(std::move(row));
    }
}

}  // namespace

Table atlas_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("atlas", "charts laid flat and packed for a texture of size_px",
                {{"input", "input"},
                 {"implementation", "implementation"},
                 {"faces", "faces"},
                 {"seconds", "s"},
                 {"processor_seconds", "cpu s"},
                 {"times_as_long", "x first (cpu)", 3},
                 {"peak_mb", "peak MB", 0},
                 {"charts", "charts"},
                 {"used_share", "used", 3},
                 {"texels_per_cm", "texels/cm", 3},
                 {"stretch_l2", "L2 stretch", 3},
                 {"stretch_linf", "Linf stretch", 3},
                 {"density_variation", "density var.", 3},
                 {"squeezed_share", "squeezed", 4},
                 {"lost_faces", "lost"},
                 {"seam_length_share", "seams", 3},
                 {"overlapping_texels", "overlaps"},
                 {"outside_corners", "outside"}});
    for (const auto& input : inputs)
    {
        add_rows(table, input.name, input.mesh, 1, settings);
        add_rows(table, input.name + ", decimated", simplified(input.mesh, settings), atlas_makers().size(), settings);
    }
    return table;
}

}  // namespace bench
