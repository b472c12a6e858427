#include "sens_file.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/recordings/layout.h>

#include <fmt/format.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <optional>
#include <string>

namespace
{

using namespace fresco::recordings;
using namespace sens;

/// Packed data may exceed twice the size of the pixels by this; no packing enlarges them by more.
constexpr std::uint64_t packing_loss = 65536;

std::string place_of(const SensFile& file, std::uint64_t offset, const std::string& name)
{
    return fmt::format("{}: byte {}, {}", file.path().string(), offset, name);
}

std::uint64_t raw_bytes(const SensCamera& camera, std::uint64_t pixel_bytes)
{
    return pixel_bytes * static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
}

/// The packed picture, unless it is larger than a picture of this size can be.
std::vector<std::byte> packed(const SensFile& file, std::uint64_t offset, std::uint64_t bytes, const SensCamera& camera,
                              std::uint64_t pixel_bytes, const std::string& name)
{
    if (bytes > 2 * raw_bytes(camera, pixel_bytes) + packing_loss)
        throw fresco::Error(fmt::format("{}: {} bytes for a picture of {}x{}: the file is damaged; copy it again",
                                        place_of(file, offset, name), bytes, camera.width, camera.height));
    return file.read_at(offset, bytes, name);
}

/// Raw values of exactly the picture's size, which is checked before it takes memory.
template <class T>
fresco::Raster<T> raw(const std::vector<std::byte>& bytes, const SensCamera& camera, int channels, const std::string& place)
{
    if (const auto expected = raw_bytes(camera, sizeof(T) * static_cast<std::uint64_t>(channels)); bytes.size() != expected)
        throw fresco::Error(fmt::format("{}: {} bytes; expected a raw picture of {} bytes: the file is damaged; copy it again",
                                        place, bytes.size(), expected));
    fresco::Raster<T> picture(camera.width, camera.height, channels);
    std::memcpy(picture.values.data(), bytes.data(), bytes.size());
    return picture;
}

class SensLayout final : public Layout
{
  public:
    fresco::Marks marks() const override
    {
        return {.formats = {
                    {.name = "a .sens recording of version 4", .extensions = {".sens"}, .begins = {std::string("\4\0\0\0", 4)}}}};
    }

  private:
    Recording list(fresco::RunContext& run) override
    {
        run.reads_file(path());
        file_.emplace(path());
        index_ = read_index(*file_);
        cameras_ = {intrinsics(index_.color, "the color camera"), intrinsics(index_.depth, "the depth camera"),
                    rigid_transform(index_.depth.extrinsics, source("the depth camera's extrinsics")).inverse() *
                        rigid_transform(index_.color.extrinsics, source("the color camera's extrinsics"))};
        Recording recording{.files = "a pose and two pictures", .note = fmt::format(", {} recorded", index_.frames.size())};
        for (std::size_t i = 0; i < index_.frames.size(); ++i)
        {
            RecordedView view;
            view.sequence = "scene";
            view.name = fmt::format("frame-{:06}", i);
            view.number = static_cast<long>(i);
            view.depth_unit_m = index_.depth_unit_m;
            view.source = source(fmt::format("byte {}, {}", index_.frames[i].color_offset, view.name));
            recording.views.push_back(std::move(view));
        }
        run.report("recorded", index_.frames.size());
        return recording;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        const auto pose = tracked_pose(frame_of(view).world_from_depth, view.source + ": the pose");
        if (pose)
            cameras_.place(view, *pose);
        return pose.has_value();
    }

    /// JPEG and PNG unchanged, raw pictures as PNG.
    bool unpack(RecordedView& view, const std::filesystem::path& folder) const override
    {
        const SensFrame& frame = frame_of(view);
        const auto color = packed(*file_, frame.color_offset, frame.color_bytes, index_.color, 3, view.name);
        view.color = folder / (view.name + (index_.color_form == ColorForm::jpeg ? ".color.jpg" : ".color.png"));
        const auto color_place = place_of(*file_, frame.color_offset, view.name);
        fresco::write_file(view.color, index_.color_form == ColorForm::raw
                                           ? codec().encode_png(raw<std::uint8_t>(color, index_.color, 3, color_place))
                                           : color);
        const auto depth = packed(*file_, frame.depth_offset, frame.depth_bytes, index_.depth, 2, view.name);
        const auto depth_place = place_of(*file_, frame.depth_offset, view.name);
        view.depth = folder / (view.name + ".depth.png");
        fresco::write_file(view.depth,
                           codec().encode_png(index_.depth_form == DepthForm::raw
                                                  ? raw<std::uint16_t>(depth, index_.depth, 1, depth_place)
                                                  : unpack_depth(depth, index_.depth.width, index_.depth.height, depth_place)));
        return true;
    }

    const SensFrame& frame_of(const RecordedView& view) const { return index_.frames[static_cast<std::size_t>(view.number)]; }
    std::string source(const std::string& what) const { return path().string() + ": " + what; }
    fresco::Intrinsics intrinsics(const SensCamera& camera, const std::string& what) const
    {
        return intrinsics_for({camera.intrinsics, source(what)}, PixelCenter::integer, {camera.width, camera.height}, path());
    }

    std::optional<SensFile> file_;
    SensIndex index_;
    RecorderCameras cameras_;
};

}  // namespace

FRESCO_COMPONENT("layout.sens", SensLayout, fresco::recordings::Layout, "ScanNet's native recordings (.sens)")
FRESCO_LIBRARY("zlib", ZLIB_VERSION)
