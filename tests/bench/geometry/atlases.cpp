#include "atlases.h"

#include "arap.h"
#include "lscm.h"
#include "peer_blender.h"

#include <fresco/geometry/map_charts.h>
#include <fresco/geometry/mesh_stages.h>

namespace bench
{
namespace
{

namespace geo = fresco::geometry;

/// As the stages do, with or without a map in place of the projection.
fresco::Mesh atlas(const fresco::Mesh& mesh, int size_px, const geo::DiskMap& map, fresco::Progress& progress)
{
    const geo::Surface surface(mesh);
    const geo::FlattenOptions options{.charts = {.angle_limit_deg = 70, .merge_limit_deg = 80},
                                      .texel_m = geo::expected_texel_m(surface, size_px)};
    geo::LayFlat lay_flat;
    if (map)
        lay_flat = [&](geo::FlatCharts& flat) { geo::map_charts(surface, flat, map, options.tolerance_m(), progress); };
    const auto flat =
        geo::project_charts(surface, geo::cut_into_charts(surface, options.charts, progress), options, progress, lay_flat);
    return geo::with_atlas(mesh, flat, geo::pack_charts(flat, {.size_px = size_px, .gutter_px = 4}, progress));
}

AtlasMaker maker(const char* name, const geo::DiskMap& map)
{
    return {name, [map](const fresco::Mesh& mesh, int size_px, fresco::Progress& progress)
            { return atlas(mesh, size_px, map, progress); }};
}

}  // namespace

const std::vector<AtlasMaker>& atlas_makers()
{
    static const std::vector<AtlasMaker> all = []
    {
        std::vector<AtlasMaker> found{maker("atlas.project", {}), maker("atlas.arap", arap_map),
                                      maker("atlas.lscm", [](const geo::Disk& disk, const auto&) { return lscm_map(disk); })};
        if (has_blender())
            found.push_back(blender_atlas());
        return found;
    }();
    return all;
}

}  // namespace bench
