#include "atlases.h"
#include "forked_case.h"
#include "map_figures.h"
#include "map_forms.h"
#include "raster_finder.h"
#include "tables.h"

#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>

namespace bench
{
namespace
{

constexpr int repeats = 15;

struct MapSums
{
    fresco::PackedUvMapBytes bytes;
    double pixels = 0;
    double pack_ms = 0;
    double unpack_ms = 0;
    MapFigures apart;
};

void add(MapSums& sums, const MapForm& form, const fresco::UvMap& map, Measure& measure)
{
    const int width = map.valid.width;
    const int height = map.valid.height;
    std::vector<std::byte> file;
    fresco::UvMap back;
    sums.pack_ms += 1e3 * measure.times(repeats, [&] { file = form.pack(map); }).processor;
    sums.unpack_ms += 1e3 * measure.times(repeats, [&] { back = form.unpack(file, width, height); }).processor;
    const auto bytes = form.bytes(file);
    sums.bytes.header += bytes.header;
    sums.bytes.validity += bytes.validity;
    sums.bytes.uv += bytes.uv;
    sums.bytes.cosine += bytes.cosine;
    sums.bytes.depth += bytes.depth;
    sums.pixels += static_cast<double>(map.valid.values.size());
    const auto apart = map_figures(map, back);
    sums.apart.other_validity_share = std::max(sums.apart.other_validity_share, apart.other_validity_share);
    sums.apart.largest_uv = std::max(sums.apart.largest_uv, apart.largest_uv);
    sums.apart.largest_depth_m = std::max(sums.apart.largest_depth_m, apart.largest_depth_m);
    sums.apart.largest_cosine = std::max(sums.apart.largest_cosine, apart.largest_cosine);
}

fresco::Value measured(const MapForm& form, const std::vector<fresco::UvMap>& maps, int size_px, Measure& measure)
{
    MapSums sums;
    for (const auto& map : maps)
        add(sums, form, map, measure);
    const auto bits = [&](std::size_t bytes) { return 8 * static_cast<double>(bytes) / sums.pixels; };
    const auto& bytes = sums.bytes;
    const std::size_t without_depth = bytes.header + bytes.validity + bytes.uv + bytes.cosine;
    const auto count = static_cast<double>(maps.size());
    return fresco::Value::Map{{"validity_bits", bits(bytes.validity)},
                              {"uv_bits", bits(bytes.uv)},
                              {"cosine_bits", bits(bytes.cosine)},
                              {"without_depth_bits", bits(without_depth)},
                              {"depth_bits", bits(bytes.depth)},
                              {"all_bits", bits(without_depth + bytes.depth)},
                              {"pack_ms", sums.pack_ms / count},
                              {"unpack_ms", sums.unpack_ms / count},
                              {"other_validity_share", sums.apart.other_validity_share},
                              {"largest_texels", sums.apart.largest_uv * size_px},
                              {"largest_cosine", sums.apart.largest_cosine},
                              {"largest_depth_mm", 1e3 * sums.apart.largest_depth_m}};
}

/// With an entry of its own for the mean over the heights, as each height is read as often as the others.
void add_rows(Table& table, const GeometryInput& input, const fresco::Mesh& atlas, const MapForm& form,
              const GeometrySettings& settings)
{
    fresco::UvMapper mapper(atlas, std::make_unique<RasterFinder>(atlas));
    fresco::Value::Map mean{{"without_depth_bits", 0.0}, {"all_bits", 0.0}};
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
                 {"validity_bits", "validity"},
                 {"uv_bits", "uv"},
                 {"cosine_bits", "cosine"},
                 {"without_depth_bits", "these three"},
                 {"depth_bits", "depth"},
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
        for (const auto& form : map_forms())
            add_rows(table, input, atlas, form, settings);
    }
    return table;
}

}  // namespace bench
