#include "view_writer.h"

#include "pictures.h"
#include "transforms.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/error.h>
#include <fresco/images/sharpness.h>
#include <fresco/uv_mapping/view_frames.h>

#include <fmt/format.h>
#include <set>
#include <utility>

using namespace fresco;

namespace
{

constexpr int sharpness_width = 320;
constexpr int sharpness_height = 240;

std::string name_of(const UvMaps::View& view)
{
    return view.sequence + "/" + view.frame;
}

}  // namespace

std::vector<std::size_t> checked_frames(const UvMaps& maps, const Frames& frames)
{
    std::set<std::pair<std::string, std::string>> names;
    for (const Frame& frame : frames.frames)
        if (!names.emplace(frame.sequence, frame.name).second)
            throw Error("frame " + frame.sequence + "/" + frame.name +
                        " appears twice on port 'frames'; rename the scan's sequences so that they differ");
    auto result = frames_of_views(maps, frames);
    for (std::size_t i = 0; i < result.size(); ++i)
        if (!(frames.frames[result[i]].color == maps.views[i].camera))
            throw Error("the uv map of " + name_of(maps.views[i]) +
                        " does not match the frame's color camera; wire "
                        "the frames that the uv maps were made from");
    return result;
}

UvMap checked_map(const UvMaps& maps, std::size_t view, std::size_t level)
{
    UvMap map = maps.load_map(view, level);
    const std::string source = fmt::format("the uv map of {} at {} px", name_of(maps.views[view]), maps.heights_px[level]);
    dataset::check_valid(map.valid, maps.views[view].valid_pixels[level], source + ", validity");
    dataset::check_uv(map.uv, source + ", uv");
    dataset::check_depth(map.depth, map.valid, source + ", depth");
    dataset::check_cosine(map.cosine, source + ", cosine");
    return map;
}

double view_sharpness(const Raster8& picture)
{
    return sharpness(picture, sharpness_width, sharpness_height);
}

WrittenFiles write_view(const std::filesystem::path& folder, const UvMaps& maps, std::size_t view, const Frame& frame,
                        const ImageIo* images, const ViewOptions& options)
{
    WrittenFiles written;
    const auto write_bytes = [&](const std::string& name, const std::vector<std::byte>& bytes)
    {
        std::filesystem::create_directories((folder / name).parent_path());
        written.files.emplace(name, dataset::write_stamped(folder / name, bytes));
    };
    const auto write = [&](const std::string& name, const auto& raster) { write_bytes(name, dataset::to_npy(raster)); };

    const Raster8 picture = load_color(frame, images);
    write(dataset::picture_name(view), picture);
    if (options.pictures)
    {
        const EncodedPicture color = encoded_color(frame, picture, *images);
        write_bytes(image_name(view, color.extension), color.bytes);
    }
    for (std::size_t level = 0; level < maps.heights_px.size(); ++level)
    {
        const int height = maps.heights_px[level];
        const UvMap map = checked_map(maps, view, level);
        if (options.uv == dataset::UvType::float32)
            write(dataset::map_name(view, "uv", height), map.uv);
        else
            write(dataset::map_name(view, "uv", height), dataset::quantized(map.uv));
        write(dataset::map_name(view, "depth", height), map.depth);
        write(dataset::map_name(view, "cosine", height), map.cosine);
        write(dataset::map_name(view, "valid", height), map.valid);
        write(dataset::map_name(view, "color", height), resized(picture, map.valid.width, map.valid.height));
        if (options.pictures && level + 1 == maps.heights_px.size())
            write_bytes(depth_image_name(view), encoded_depth(map.depth, *images));
    }
    if (!frame.depth_picture.empty())
        write(dataset::sensor_depth_name(view), load_depth_steps(frame, images));
    written.sharpness = view_sharpness(picture);
    return written;
}

dataset::View view_entry(const UvMaps& maps, std::size_t view, const Frame& frame, const WrittenFiles& written)
{
    dataset::View entry;
    entry.sequence = frame.sequence;
    entry.frame = frame.name;
    entry.number = frame.number;
    entry.color = frame.color;
    entry.depth = frame.depth;
    if (!frame.depth_picture.empty())
        entry.depth_unit_m = frame.depth_unit_m;
    entry.sharpness = written.sharpness;
    entry.valid_pixels = maps.views[view].valid_pixels;
    return entry;
}
