#include "stylemesh_layout.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/images/sharpness.h>
#include <fresco/npy.h>
#include <fresco/texturing/exports.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <set>
#include <span>
#include <utility>

using namespace fresco;

namespace
{
std::string pose_text(const RigidTransform& world_from_camera)
{
    const Mat3& r = world_from_camera.rotation;
    const Vec3d t = world_from_camera.translation;
    const double translation[] = {t.x, t.y, t.z};
    std::string text;  // Its numbers read back exactly.
    for (int row = 0; row < 3; ++row)
        text += to_json(r(row, 0)) + " " + to_json(r(row, 1)) + " " + to_json(r(row, 2)) + " " + to_json(translation[row]) + "\n";
    return text + "0.0 0.0 0.0 1.0\n";
}

std::string camera_lines(const Intrinsics& k, const std::string& name)
{
    return fmt::format("{0}Height = {1}\n{0}Width = {2}\nfx_{0} = {3}\nfy_{0} = {4}\nmx_{0} = {5}\nmy_{0} = {6}\n", name,
                       k.height, k.width, to_json(k.fx), to_json(k.fy), to_json(k.cx), to_json(k.cy));
}

void check_scene_name(const std::string& scene)
{
    const auto good = [](char c)
    { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
    const std::size_t underscores = static_cast<std::size_t>(std::ranges::count(scene, '_'));
    if (!std::ranges::all_of(scene, good) || underscores != 1 || scene.front() == '_' || scene.back() == '_')
        throw Error("option \"scene\": \"" + scene +
                    "\"; expected two parts of letters and digits, such as \"scene0000_00\": readers of this layout split the "
                    "name at '_'");
}

/// Texcoords as the released renderer writes them: v from the top, 0 where nothing is seen.
RasterF turned(const UvMap& map)
{
    RasterF uv = map.uv;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        if (map.valid.values[i] != 0)
            uv.values[2 * i + 1] = 1 - uv.values[2 * i + 1];
    return uv;
}

/// H x W x 1: what reads it takes the first channel.
std::vector<std::byte> one_channel(const RasterF& raster)
{
    const std::array shape{static_cast<std::size_t>(raster.height), static_cast<std::size_t>(raster.width), std::size_t{1}};
    return to_npy(NpyType::float32, shape, std::as_bytes(std::span(raster.values)));
}

std::span<const std::byte> bytes_of(const std::string& text)
{
    return std::as_bytes(std::span(text));
}
}  // namespace

StylemeshLayout::StylemeshLayout(std::string scene, const UvMaps& maps, const Frames& frames,
                                 const std::vector<std::size_t>& frame_of)
    : scene_(std::move(scene)), maps_(maps), frames_(frames), frame_of_(frame_of)
{
    check_scene_name(scene_);
    std::set<long> unique;
    for (std::size_t view = 0; view < frame_of.size(); ++view)
    {
        const Frame& shown = frame(view);
        if (!(shown.color.intrinsics == frame(0).color.intrinsics))
            throw Error("layout: stylemesh: frame " + shown.sequence + "/" + shown.name + " has other color intrinsics than " +
                        frame(0).sequence + "/" + frame(0).name +
                        "; this layout has one file for all frames: use frames of one camera, or set layout: fresco");
        has_sensor_depth_ = has_sensor_depth_ && !shown.depth_picture.empty();
        numbers_.push_back(shown.number);
        unique.insert(shown.number);
    }
    if (unique.size() != numbers_.size() || *unique.begin() < 0)
        for (std::size_t view = 0; view < numbers_.size(); ++view)
            numbers_[view] = static_cast<long>(view);
}

std::string StylemeshLayout::file(const std::string& folder, std::size_t view, const std::string& extension) const
{
    return fmt::format("train/images/{}/{}/{}{}", scene_, folder, number(view), extension);
}

WrittenFiles StylemeshLayout::write_view(const std::filesystem::path& folder, std::size_t view, const ImageIo& images) const
{
    WrittenFiles written;
    const Frame& shown = frame(view);
    const Raster8 picture = load_color(shown, &images);
    written.sharpness = usual_sharpness(picture);
    written.write(folder, file("color", view, ".png"), images.encode_png(exported_for_stylemesh(picture)));
    written.write(folder, file("pose", view, ".txt"), bytes_of(pose_text(shown.color.world_from_camera)));
    if (has_sensor_depth_)
        written.write(folder, file("depth", view, ".png"),
                      encoded_depth(exported_for_stylemesh(load_depth(shown, &images)), images));
    for (std::size_t level = 0; level < maps_.heights_px.size(); ++level)
    {
        const UvMap map = checked_map(maps_, view, level);
        written.write(folder, file(fmt::format("uv_{}", maps_.heights_px[level]), view, ".npy"), dataset::to_npy(turned(map)));
        if (level != 0)
            continue;
        written.write(folder, file("uv", view, ".angle.npy"), one_channel(map.cosine));
        if (!has_sensor_depth_)
            written.write(folder, file("depth", view, ".png"), encoded_depth(map.depth, images));
    }
    return written;
}

WrittenFiles StylemeshLayout::write_scene(const std::filesystem::path& folder, const Mesh& mesh) const
{
    WrittenFiles written;
    const std::string intrinsics =
        camera_lines(frame(0).color.intrinsics, "color") + camera_lines(frame(0).depth.intrinsics, "depth");
    const std::string scan = "train/scans/" + scene_ + "/" + scene_;
    written.write(folder, "train/images/" + scene_ + "/" + scene_ + ".txt", bytes_of(intrinsics));
    written.write(folder, scan + ".txt", bytes_of(intrinsics));
    Mesh colorless = mesh;
    colorless.colors.clear();
    written.write(folder, scan + "_vh_clean_decimate_500000_uvs_blender.ply",
                  texturing::textured_ply(texturing::split_at_seams(colorless), ""));
    return written;
}
