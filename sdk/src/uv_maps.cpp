#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/run_context.h>
#include <fresco/uv_maps.h>

#include <fmt/format.h>

namespace fresco
{
namespace
{

namespace fs = std::filesystem;

fs::path map_file(const fs::path& folder, std::size_t view, int height_px)
{
    return folder / fmt::format("{:06}_{}.uvmap", view, height_px);
}

constexpr int most_texture_px = 262144;
constexpr int largest_height_px = 65536;

}  // namespace

void UvMaps::write_map(const ArtifactFolder& folder, std::size_t view, int height_px, const UvMap& map, int uv_bits)
{
    const fs::path file = map_file(folder.path, view, height_px);
    write_file(file, pack_uv_map(map, uv_bits, file.string()));
}

UvMap UvMaps::load_map(std::size_t view, std::size_t level) const
{
    const int height = heights_px.at(level);
    const fs::path file = map_file(folder_, view, height);
    return unpack_uv_map(read_file(file), views.at(view).camera.intrinsics.width_at(height), height, file.string());
}

void UvMaps::save(const ArtifactFolder& folder) const
{
    Value::List list;
    for (const View& view : views)
        list.emplace_back(Value::Map{{"sequence", view.sequence},
                                     {"frame", view.frame},
                                     {"camera", to_value(view.camera)},
                                     {"valid_pixels", Value::List(view.valid_pixels.begin(), view.valid_pixels.end())}});
    write_file(folder.path / "uvmaps.json", to_json(Value::Map{{"atlas", atlas},
                                                               {"texture_px", texture_px},
                                                               {"uv_bits", uv_bits},
                                                               {"heights_px", Value::List(heights_px.begin(), heights_px.end())},
                                                               {"views", std::move(list)}},
                                                    1));
}

std::shared_ptr<UvMaps> UvMaps::load(const ArtifactFolder& folder)
{
    const detail::JsonFile file(folder.path / "uvmaps.json");
    auto result = std::make_shared<UvMaps>();
    result->folder_ = folder.path;
    result->atlas = file["atlas"].text();
    result->texture_px = static_cast<int>(file["texture_px"].integer(0, most_texture_px));
    result->uv_bits = static_cast<int>(file["uv_bits"].integer(min_uv_bits, max_uv_bits));
    for (const JsonPlace& height : file["heights_px"].list())
        result->heights_px.push_back(static_cast<int>(height.integer(1, largest_height_px)));
    for (const JsonPlace& place : file["views"].list())
    {
        View view;
        view.sequence = place["sequence"].text();
        view.frame = place["frame"].text();
        view.camera = camera_from(place["camera"]);
        for (const JsonPlace& count : place["valid_pixels"].list(result->heights_px.size()))
            view.valid_pixels.push_back(count.integer());
        result->views.push_back(std::move(view));
    }
    return result;
}

std::vector<ExchangeForm> UvMaps::exchange_forms()
{
    return {{.files = {"uvmaps.json"}}};
}

std::shared_ptr<UvMaps> UvMaps::from_exchange(const Exchange& from)
{
    auto maps = load(from.folder);
    for (std::size_t view = 0; view < maps->views.size(); ++view)
        for (std::size_t level = 0; level < maps->heights_px.size(); ++level)
        {
            from.run.check_canceled();
            (void)maps->load_map(view, level);
        }
    return maps;
}

void check_uv_bits(const UvMaps& maps, int size_px, std::string_view source)
{
    if (uv_bits_for_texture(size_px) <= maps.uv_bits)
        return;
    int served = 1;
    while (uv_bits_for_texture(2 * served) <= maps.uv_bits)
        served *= 2;
    throw Error(fmt::format("{} hold texcoords of {} bits, for textures up to {} texels a side, not {}: set size_px of the "
                            "atlas.* stage to {}, or paint at {}",
                            source, maps.uv_bits, served, size_px, size_px, served));
}

}  // namespace fresco
