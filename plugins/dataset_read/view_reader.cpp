#include "view_reader.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/files_io.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <vector>

using namespace fresco;

namespace
{

/// Reads the files of one dataset.
class Source
{
  public:
    Source(const dataset::Manifest& manifest, std::filesystem::path folder) : manifest_(manifest), folder_(std::move(folder)) {}

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::vector<std::byte> bytes(const std::string& name) const
    {
        return dataset::read_stamped(folder_ / name, manifest_.files.at(name));
    }
    RasterF floats(const std::string& name, int width, int height, int channels) const
    {
        return dataset::raster_f_from(bytes(name), width, height, channels, path(name));
    }
    Raster8 picture(const std::string& name, int width, int height, int channels) const
    {
        return dataset::raster8_from(bytes(name), width, height, channels, path(name));
    }
    Raster16 steps(const std::string& name, int width, int height, int channels) const
    {
        return dataset::raster16_from(bytes(name), width, height, channels, path(name));
    }
    RasterF uv(const std::string& name, int width, int height) const
    {
        return manifest_.uv == dataset::UvType::float32 ? floats(name, width, height, 2)
                                                        : dataset::restored(steps(name, width, height, 2));
    }

  private:
    const dataset::Manifest& manifest_;
    std::filesystem::path folder_;
};

UvMap read_map(const Source& source, const dataset::View& entry, std::size_t view, std::size_t level, int height)
{
    const int width = entry.color.intrinsics.width_at(height);
    const auto name = [&](const char* quantity) { return dataset::map_name(view, quantity, height); };
    UvMap map;
    map.valid = source.picture(name("valid"), width, height, 1);
    dataset::check_valid(map.valid, entry.valid_pixels[level], source.path(name("valid")));
    map.uv = source.uv(name("uv"), width, height);
    dataset::check_uv(map.uv, source.path(name("uv")));
    map.depth = source.floats(name("depth"), width, height, 1);
    dataset::check_depth(map.depth, map.valid, source.path(name("depth")));
    map.cosine = source.floats(name("cosine"), width, height, 1);
    dataset::check_cosine(map.cosine, source.path(name("cosine")));
    return map;
}

}  // namespace

ReadView read_view(const dataset::Manifest& manifest, std::size_t view, const ViewFolders& folders)
{
    const Source source(manifest, folders.dataset);
    const dataset::View& entry = manifest.views[view];
    ReadView read;
    for (std::size_t level = 0; level < manifest.heights_px.size(); ++level)
    {
        const int height = manifest.heights_px[level];
        const UvMap map = read_map(source, entry, view, level, height);
        // Of a dataset that was made from stored maps, the same steps again.
        const int uv_bits = uv_bits_of(map);
        UvMaps::write_map(folders.uvmaps, view, height, map, uv_bits);
        read.uv_bits = std::max(read.uv_bits, uv_bits);
        source.picture(dataset::map_name(view, "color", height), entry.color.intrinsics.width_at(height), height, 3);
    }

    Frame& frame = read.frame;
    frame.sequence = entry.sequence;
    frame.name = entry.frame;
    frame.number = entry.number;
    frame.color = entry.color;
    frame.depth = entry.depth;
    const auto write = [&](const char* quantity, const auto& picture)
    {
        const auto file = folders.frames / fmt::format("{}.{}.npy", view, quantity);
        write_file(file, dataset::to_npy(picture));
        return PictureFile{file, ""};
    };
    const Intrinsics& depth = entry.depth.intrinsics;
    const Intrinsics& color = entry.color.intrinsics;
    frame.color_picture = write("color", source.picture(dataset::picture_name(view), color.width, color.height, 3));
    if (entry.depth_unit_m)
    {
        frame.depth_unit_m = *entry.depth_unit_m;
        frame.depth_picture = write("depth", source.steps(dataset::sensor_depth_name(view), depth.width, depth.height, 1));
    }
    return read;
}
