#include "view_writer.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/error.h>
#include <fresco/sharpness.h>
#include <fresco/view_frames.h>

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

void check_map(const UvMap& map, std::int64_t valid_pixels, const std::string& source)
{
    dataset::check_valid(map.valid, valid_pixels, source + ", validity");
    dataset::check_uv(map.uv, source + ", uv");
    dataset::check_depth(map.depth, map.valid, source + ", depth");
    dataset::check_cosine(map.cosine, source + ", cosine");
}

}  // namespace

std::vector<std::size_t> checked_frames(const UvMaps& maps, const Frames& frames)
{
    std::set<std::pair<std::string, std::string>> names;
    for (const Frame& frame : frames.frames)
        if (!names.emplace(frame.sequence, frame.name).second)
            throw Error("the frame " + frame.sequence + "/" + frame.name + " is there twice on port 'frames'");
    auto result = frames_of_views(maps, frames);
    for (std::size_t i = 0; i < result.size(); ++i)
        if (!(frames.frames[result[i]].color == maps.views[i].camera))
            throw Error("the uv map of " + name_of(maps.views[i]) +
                        " was made for another colour camera than the frame's; wire "
                        "the frames that the uv maps were made from");
    return result;
}

WrittenView write_view(const std::filesystem::path& folder, const UvMaps& maps, std::size_t view, const Frame& frame,
                       const ImageIo* images, dataset::UvType uv)
{
    WrittenView written;
    const auto write = [&](const std::string& name, const auto& raster)
    { written.files.emplace(name, dataset::write_stamped(folder / name, dataset::to_npy(raster))); };
    std::filesystem::create_directories((folder / dataset::picture_name(view)).parent_path());

    const Raster8 picture = load_color(frame, images);
    write(dataset::picture_name(view), picture);
    for (std::size_t level = 0; level < maps.heights_px.size(); ++level)
    {
        const int height = maps.heights_px[level];
        const UvMap map = maps.load_map(view, level);
        check_map(map, maps.views[view].valid_pixels[level],
                  "the uv map of " + name_of(maps.views[view]) + " at " + std::to_string(height) + " px");
        if (uv == dataset::UvType::float32)
            write(dataset::map_name(view, "uv", height), map.uv);
        else
            write(dataset::map_name(view, "uv", height), dataset::quantised(map.uv));
        write(dataset::map_name(view, "depth", height), map.depth);
        write(dataset::map_name(view, "cosine", height), map.cosine);
        write(dataset::map_name(view, "valid", height), map.valid);
        write(dataset::map_name(view, "color", height), resized(picture, map.valid.width, map.valid.height));
    }
    if (!frame.depth_picture.empty())
        write(dataset::sensor_depth_name(view), load_depth_steps(frame, images));

    dataset::View& entry = written.view;
    entry.sequence = frame.sequence;
    entry.frame = frame.name;
    entry.number = frame.number;
    entry.color = frame.color;
    entry.depth = frame.depth;
    if (!frame.depth_picture.empty())
        entry.depth_unit_m = frame.depth_unit_m;
    entry.sharpness = sharpness(picture, sharpness_width, sharpness_height);
    entry.valid_pixels = maps.views[view].valid_pixels;
    return written;
}
