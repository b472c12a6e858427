#include "atlases.h"

#include "conformal.h"

#include <fresco/geometry/atlas.h>

namespace bench
{
namespace
{

namespace geo = fresco::geometry;

fresco::Mesh atlas(const fresco::Mesh& mesh, int size_px, bool conformal, fresco::Progress& progress)
{
    const geo::Surface surface(mesh);
    const geo::FlattenOptions options{.charts = {}, .texel_m = geo::expected_texel_m(surface, size_px)};
    auto flat = geo::project_charts(surface, geo::cut_into_charts(surface, options.charts, progress), options, progress);
    if (conformal)
        lay_conformal(surface, flat, options.tolerance_m(), progress);
    return geo::with_atlas(mesh, flat, geo::pack_charts(flat, {.size_px = size_px}, progress));
}

}  // namespace

const std::vector<AtlasMaker>& atlas_makers()
{
    static const std::vector<AtlasMaker> all{
        {"atlas.project", [](const auto& mesh, int size_px, auto& progress) { return atlas(mesh, size_px, false, progress); }},
        {"atlas.lscm", [](const auto& mesh, int size_px, auto& progress) { return atlas(mesh, size_px, true, progress); }}};
    return all;
}

}  // namespace bench
