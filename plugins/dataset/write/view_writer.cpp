#include "view_writer.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/images/sharpness.h>
#include <fresco/uv_mapping/view_frames.h>
#include <fresco/wording.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

using namespace fresco;

std::vector<std::string> WrittenFiles::names() const
{
    std::vector<std::string> result;
    for (const auto& [name, stamp] : files)
        result.push_back(name);
    return result;
}

void WrittenFiles::write(const std::filesystem::path& folder, const std::string& name, std::span<const std::byte> bytes)
{
    std::filesystem::create_directories((folder / name).parent_path());
    files.emplace(name, dataset::write_stamped(folder / name, bytes));
}

Value to_value(const WrittenFiles& written)
{
    return Value::Map{{"sharpness", written.sharpness}, {"files", dataset::stamps_value(written.files)}};
}

WrittenFiles written_files_from(const Value& value)
{
    WrittenFiles written;
    written.sharpness = value.at("sharpness").as_double();
    for (const Value& file : value.at("files").as_list())
        written.files[file.at("name").as_string()] = {static_cast<std::uint64_t>(file.at("bytes").as_int()),
                                                      file.at("hash").as_string()};
    return written;
}

namespace
{

constexpr float millimeters = 1000;
constexpr float no_depth_from = 65534.5F;  // 65535 means none in many readers

/// 8-bit RGB, which every reader of a dataset expects: a PNG's header has both at fixed places.
bool is_plain_png(const std::vector<std::byte>& bytes)
{
    constexpr std::size_t bits_at = 24, kind_at = 25;
    return bytes.size() > kind_at && bytes.front() == std::byte{0x89} && bytes[bits_at] == std::byte{8} &&
           bytes[kind_at] == std::byte{2};
}

}  // namespace

EncodedPicture encoded_color(const Frame& frame, const Raster8& picture, const ImageIo& images)
{
    const std::string extension = lower_extension(frame.color_picture.path);
    const bool is_jpeg = extension == ".jpg" || extension == ".jpeg";
    if (!is_jpeg && extension != ".png")
        return {".png", images.encode_png(picture)};
    auto bytes = read_file(frame.color_picture.path);
    if (!frame.color_picture.hash.empty() && content_hash(bytes) != frame.color_picture.hash)
        throw Error(frame.color_picture.path.string() + ": the file changed while it was read; run again");
    // Programs save pictures of one kind by names of the other.
    const bool begins_so = is_jpeg ? !bytes.empty() && bytes.front() == std::byte{0xFF} : is_plain_png(bytes);
    if (!begins_so)
        return {".png", images.encode_png(picture)};
    return {is_jpeg ? ".jpg" : ".png", std::move(bytes)};
}

std::vector<std::byte> encoded_depth(const RasterF& depth, const ImageIo& images)
{
    Raster16 steps(depth.width, depth.height);
    std::ranges::transform(depth.values, steps.values.begin(),
                           [](float meters)
                           {
                               const float step = std::round(meters * millimeters);
                               return step < no_depth_from ? static_cast<std::uint16_t>(step) : std::uint16_t{0};
                           });
    return images.encode_png(steps);
}

namespace
{

/// Four rows of world_from_camera for a camera whose y points up and whose z points backward.
Value opengl_pose(const RigidTransform& world_from_camera)
{
    const Mat3& r = world_from_camera.rotation;
    const Vec3d t = world_from_camera.translation;
    const double translation[] = {t.x, t.y, t.z};
    Value::List rows;
    for (int row = 0; row < 3; ++row)
        // 0 - x, not -x: no "-0.0" in the text.
        rows.emplace_back(Value::List{r(row, 0), 0 - r(row, 1), 0 - r(row, 2), translation[row]});
    rows.emplace_back(Value::List{0.0, 0.0, 0.0, 1.0});
    return rows;
}

Value frame_of(const dataset::Manifest& manifest, std::size_t view)
{
    const Camera& camera = manifest.views[view].color;
    const Intrinsics& k = camera.intrinsics;
    const std::string jpeg = image_name(view, ".jpg");
    return Value::Map{{"file_path", manifest.files.contains(jpeg) ? jpeg : image_name(view, ".png")},
                      {"depth_file_path", depth_image_name(view)},
                      {"w", k.width},
                      {"h", k.height},
                      {"fl_x", k.fx},
                      {"fl_y", k.fy},
                      {"cx", k.cx},
                      {"cy", k.cy},
                      {"transform_matrix", opengl_pose(camera.world_from_camera)}};
}

}  // namespace

std::string image_name(std::size_t view, const std::string& extension)
{
    return fmt::format("images/{:06}{}", view, extension);
}

std::string depth_image_name(std::size_t view)
{
    return fmt::format("depth/{:06}.png", view);
}

std::string transforms_text(const dataset::Manifest& manifest)
{
    Value::List frames;
    for (std::size_t view = 0; view < manifest.views.size(); ++view)
        frames.push_back(frame_of(manifest, view));
    const Value root = Value::Map{{"camera_model", "PINHOLE"}, {"depth_unit_scale_factor", 0.001}, {"frames", std::move(frames)}};
    return to_json(root, 1) + "\n";
}

namespace
{

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

WrittenFiles write_view(const std::filesystem::path& folder, const UvMaps& maps, std::size_t view, const Frame& frame,
                        const ImageIo* images, const ViewOptions& options)
{
    WrittenFiles written;
    const auto write = [&](const std::string& name, const auto& raster) { written.write(folder, name, dataset::to_npy(raster)); };

    const Raster8 picture = load_color(frame, images);
    write(dataset::picture_name(view), picture);
    if (options.pictures)
    {
        const EncodedPicture color = encoded_color(frame, picture, *images);
        written.write(folder, image_name(view, color.extension), color.bytes);
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
            written.write(folder, depth_image_name(view), encoded_depth(map.depth, *images));
    }
    if (!frame.depth_picture.empty())
        write(dataset::sensor_depth_name(view), load_depth_steps(frame, images));
    written.sharpness = usual_sharpness(picture);
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
