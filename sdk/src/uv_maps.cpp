#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/uv_maps.h>

#include <cstdio>

namespace fresco
{
namespace
{

namespace fs = std::filesystem;

fs::path map_file(const fs::path& folder, std::size_t view, int height_px, const char* quantity)
{
    char number[24];
    std::snprintf(number, sizeof number, "%06zu", view);
    return folder / (std::string(number) + "_" + std::to_string(height_px) + "." + quantity + ".npy");
}

template <class T>
void check_size(const Raster<T>& raster, int width, int height, const fs::path& file)
{
    if (raster.width != width || raster.height != height)
        throw Error(file.string() + ": is " + std::to_string(raster.width) + "x" + std::to_string(raster.height) +
                    "; the index says " + std::to_string(width) + "x" + std::to_string(height));
}

}  // namespace

UvMaps::~UvMaps() = default;

void UvMaps::write_map(const ArtifactFolder& folder, std::size_t view, int height_px, const UvMap& map)
{
    detail::write_raster(map_file(folder.path, view, height_px, "uv"), map.uv);
    detail::write_raster(map_file(folder.path, view, height_px, "depth"), map.depth);
    detail::write_raster(map_file(folder.path, view, height_px, "cosine"), map.cosine);
    detail::write_raster(map_file(folder.path, view, height_px, "valid"), map.valid);
}

UvMap UvMaps::load_map(std::size_t view, std::size_t level) const
{
    const int height = heights_px.at(level);
    const int width = views.at(view).camera.intrinsics.width_at(height);
    UvMap map;
    const auto read = [&](const char* quantity, int channels, auto& raster)
    {
        const fs::path file = map_file(folder_, view, height, quantity);
        if constexpr (std::is_same_v<decltype(raster), Raster8&>)
            raster = detail::read_raster8(file, channels);
        else
            raster = detail::read_raster_f(file, channels);
        check_size(raster, width, height, file);
    };
    read("uv", 2, map.uv);
    read("depth", 1, map.depth);
    read("cosine", 1, map.cosine);
    read("valid", 1, map.valid);
    return map;
}

void UvMaps::save(const ArtifactFolder& folder) const
{
    Value::List list;
    for (const View& view : views)
        list.emplace_back(Value::Map{{"sequence", view.sequence},
                                     {"frame", view.frame},
                                     {"camera", detail::to_value(view.camera)},
                                     {"valid_pixels", Value::List(view.valid_pixels.begin(), view.valid_pixels.end())}});
    write_file(
        folder.path / "uvmaps.json",
        to_json(Value::Map{{"heights_px", Value::List(heights_px.begin(), heights_px.end())}, {"views", std::move(list)}}, 1));
}

std::shared_ptr<UvMaps> UvMaps::load(const ArtifactFolder& folder)
{
    const fs::path file = folder.path / "uvmaps.json";
    const Value root = detail::read_json_file(file);
    auto result = std::make_shared<UvMaps>();
    result->folder_ = folder.path;
    for (const Value& height : root.at("heights_px").as_list())
        result->heights_px.push_back(static_cast<int>(height.as_int()));
    for (const Value& value : root.at("views").as_list())
    {
        View view;
        view.sequence = value.at("sequence").as_string();
        view.frame = value.at("frame").as_string();
        view.camera = detail::camera_from(value.at("camera"), file.string());
        for (const Value& count : value.at("valid_pixels").as_list())
            view.valid_pixels.push_back(count.as_int());
        if (view.valid_pixels.size() != result->heights_px.size())
            throw Error(file.string() + ": view " + view.sequence + "/" + view.frame + " has no count per height");
        result->views.push_back(std::move(view));
    }
    return result;
}

}  // namespace fresco
