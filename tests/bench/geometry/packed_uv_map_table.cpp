#include "atlases.h"
#include "forked_case.h"
#include "map_figures.h"
#include "tables.h"
#include <fresco/rendering/raster_finder.h>

#include <fresco/uv_mapping/uv_mapper.h>
#include <fresco/uv_maps.h>

#include <algorithm>

namespace bench
{
namespace
{

constexpr int repeats = 15;

/// The store's form for a texture.
struct MapForm
{
    const char* name;
    int uv_bits;
};

fresco::Value measured(const MapForm& form, const std::vector<fresco::UvMap>& maps, int size_px, Measure& measure)
{
    double bits = 0;
    double pixels = 0;
    double pack_ms = 0;
    double unpack_ms = 0;
    MapFigures apart;
    for (const auto& map : maps)
    {
        const int width = map.valid.width;
        const int height = map.valid.height;
        std::vector<std::byte> file;
        fresco::UvMap back;
        pack_ms += 1e3 * measure.times(repeats, [&] { file = fresco::pack_uv_map(map, form.uv_bits, "bench"); }).processor;
        unpack_ms += 1e3 * measure.times(repeats, [&] { back = fresco::unpack_uv_map(file, width, height, "bench"); }).processor;
        bits += 8 * static_cast<double>(file.size());
        pixels += static_cast<double>(map.valid.values.size());
        const auto figures = map_figures(map, back);
        apart.other_validity_share = std::max(apart.other_validity_share, figures.other_validity_share);
        apart.largest_uv = std::max(apart.largest_uv, figures.largest_uv);
        apart.largest_depth_m = std::max(apart.largest_depth_m, figures.largest_depth_m);
        apart.largest_cosine = std::max(apart.largest_cosine, figures.largest_cosine);
    }
    const auto count = static_cast<double>(maps.size());
    return fresco::Value::Map{{"all_bits", bits / pixels},
                              {"pack_ms", pack_ms / count},
                              {"unpack_ms", unpack_ms / count},
                              {"other_validity_share", apart.other_validity_share},
                              {"largest_texels", apart.largest_uv * size_px},
                              {"largest_cosine", apart.largest_cosine},
                              {"largest_depth_mm", 1e3 * apart.largest_depth_m}};
}

/// With an entry of its own for the mean over the heights, as each height is read as often as the others.
void add_rows(Table& table, const GeometryInput& input, const fresco::Mesh& atlas, const MapForm& form,
              const GeometrySettings& settings)
{
    fresco::UvMapper mapper(atlas, std::make_unique<fresco::rendering::RasterFinder>(atlas));
    fresco::Value::Map mean{{"all_bits", 0.0}};
    for (const int height : settings.heights_px)
    {
        std::vector<fresco::UvMap> maps;
        for (const auto& camera : input.cameras)
            maps.push_back(mapper.make(camera, std::span(&height, 1), fresco::Progress()).front().map);
        auto row = run_case([&](Measure& measure) { return measured(form, maps, settings.size_px, measure); });
        row.set("input", input.name);
        row.set("faces", atlas.triangles.size());
        row.set("form", form.name);
        row.set("height_px", height);
        for (auto& [key, sum] : mean)
            if (const auto bits = entry(row, key); !bits.is_null())
                sum = sum.as_double() + bits.as_double() / static_cast<double>(settings.heights_px.size());
        table.add(std::move(row));
    }
    fresco::Value row{std::move(mean)};
    row.set("input", input.name);
    row.set("faces", atlas.triangles.size());
    row.set("form", form.name);
    row.set("height_px", "mean");
    table.add(std::move(row));
}

}  // namespace

Table packed_uv_map_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("packed uv maps", "bits per pixel of uv maps as files, and the time to pack and unpack one on one thread",
                {{"input", "input"},
                 {"faces", "faces"},
                 {"form", "form"},
                 {"height_px", "height px"},
                 {"all_bits", "all"},
                 {"pack_ms", "pack cpu ms"},
                 {"unpack_ms", "unpack cpu ms"},
                 {"largest_texels", "texels apart", 4},
                 {"largest_cosine", "cosine apart", 5},
                 {"largest_depth_mm", "depth apart mm", 3}});
    for (const auto& input : inputs)
    {
        Threads progress(settings.threads);
        const auto atlas = atlas_makers().front().run(simplified(input.mesh, settings), settings.size_px, progress);
        for (const auto& form :
             {MapForm{"for 4096 texels", fresco::min_uv_bits}, {"for 16384 texels", fresco::uv_bits_for_texture(16384)}})
            add_rows(table, input, atlas, form, settings);
    }
    return table;
}

}  // namespace bench
