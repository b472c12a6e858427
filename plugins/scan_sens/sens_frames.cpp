#include "sens_frames.h"

#include "sens_depth.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/matrix_text.h>
#include <fresco/parallel.h>
#include <fresco/recording.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <optional>

namespace sens
{
namespace
{

namespace fs = std::filesystem;

/// What packed data may have beyond the pixels' own: no packing enlarges them by more.
constexpr std::uint64_t packing_loss = 65536;

std::string frame_name(std::size_t number)
{
    const auto digits = std::to_string(number);
    return "frame-" + std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits;
}

fresco::Intrinsics intrinsics_of(const SensCamera& camera, const std::string& source, const fs::path& file)
{
    const auto k =
        fresco::intrinsics_from_matrix(camera.intrinsics, fresco::PixelCenter::integer, camera.width, camera.height, source);
    fresco::check_center(k, source, file);
    return k;
}

class Extractor
{
  public:
    Extractor(const SensFile& file, const SensIndex& index, const fresco::ImageIo& images, const fs::path& folder)
        : file_(file), index_(index), images_(images), folder_(folder),
          color_(intrinsics_of(index.color, source("the color camera"), file.path())),
          depth_(intrinsics_of(index.depth, source("the depth camera"), file.path())),
          depth_from_color_(fresco::rigid_transform(index.depth.extrinsics, source("the depth camera's extrinsics")).inverse() *
                            fresco::rigid_transform(index.color.extrinsics, source("the color camera's extrinsics")))
    {
    }

    /// Nothing where the recorder had lost track.
    std::optional<fresco::Frame> extract(std::size_t number) const
    {
        const auto& from = index_.frames[number];
        const auto& pose = from.world_from_depth;
        if (!std::all_of(pose.begin(), pose.end(), [](double entry) { return std::isfinite(entry); }))
            return std::nullopt;
        fresco::Frame frame;
        frame.sequence = "scene";
        frame.name = frame_name(number);
        frame.number = static_cast<long>(number);
        const std::string pose_source = source("the pose of frame " + std::to_string(number));
        frame.depth = {depth_, fresco::rigid_transform(pose, pose_source)};
        frame.color = {color_, frame.depth.world_from_camera * depth_from_color_};
        check_camera(frame.depth, pose_source);
        check_camera(frame.color, pose_source);
        frame.depth_unit_m = index_.depth_unit_m;
        frame.color_picture = {write_color(from, frame.name), ""};
        frame.depth_picture = {write_depth(from, frame.name), ""};
        return frame;
    }

  private:
    std::string source(const std::string& what) const { return file_.path().string() + ": " + what; }
    std::string place(std::uint64_t offset, const std::string& name) const
    {
        return file_.path().string() + ": byte " + std::to_string(offset) + ", " + name;
    }

    /// The packed picture, unless it is larger than a picture of this size can be.
    std::vector<std::byte> packed(std::uint64_t offset, std::uint64_t bytes, const SensCamera& camera, std::uint64_t pixel_bytes,
                                  const std::string& name) const
    {
        const auto most = 2 * pixel_bytes * static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
        if (bytes > most + packing_loss)
            throw fresco::Error(place(offset, name) + ": " + std::to_string(bytes) + " bytes for a picture of " +
                                std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                                "; the file is damaged; copy it again");
        return file_.read_at(offset, bytes, name);
    }

    /// Raw values of exactly the picture's size, which is checked before it takes memory.
    template <class T>
    fresco::Raster<T> raw(const std::vector<std::byte>& bytes, const SensCamera& camera, int channels,
                          const std::string& where) const
    {
        const auto expected = sizeof(T) * static_cast<std::size_t>(channels) * static_cast<std::size_t>(camera.width) *
                              static_cast<std::size_t>(camera.height);
        if (bytes.size() != expected)
            throw fresco::Error(where + ": " + std::to_string(bytes.size()) + " bytes where a raw picture has " +
                                std::to_string(expected) + "; the file is damaged; copy it again");
        fresco::Raster<T> picture(camera.width, camera.height, channels);
        std::memcpy(picture.values.data(), bytes.data(), bytes.size());
        return picture;
    }

    fs::path write_color(const SensFrame& from, const std::string& name) const
    {
        const auto bytes = packed(from.color_offset, from.color_bytes, index_.color, 3, name);
        const auto where = place(from.color_offset, name);
        const auto file = folder_ / (name + (index_.color_form == ColorForm::jpeg ? ".color.jpg" : ".color.png"));
        if (index_.color_form == ColorForm::raw)
        {
            fresco::write_file(file, images_.encode_png(raw<std::uint8_t>(bytes, index_.color, 3, where)));
            return file;
        }
        fresco::write_file(file, bytes);
        const auto header = checked(file, where);
        if (header.width != index_.color.width || header.height != index_.color.height)
            throw fresco::Error(where + ": the color picture is " + std::to_string(header.width) + "x" +
                                std::to_string(header.height) + ", the file's head says " + std::to_string(index_.color.width) +
                                "x" + std::to_string(index_.color.height));
        if (header.orientation != 1)
            throw fresco::Error(where + ": the color picture's EXIF data says that it is to be turned (orientation " +
                                std::to_string(header.orientation) + "), but its pose is for the pixels as they are stored");
        return file;
    }

    /// The codec knows the picture by a name that the user has never seen.
    fresco::ImageHeader checked(const fs::path& file, const std::string& where) const
    {
        try
        {
            return images_.check(file);
        }
        catch (const fresco::Error& error)
        {
            throw fresco::Error(where + ": the color picture cannot be used; the file is damaged; copy it again (" +
                                error.what() + ")");
        }
    }

    fs::path write_depth(const SensFrame& from, const std::string& name) const
    {
        const auto bytes = packed(from.depth_offset, from.depth_bytes, index_.depth, 2, name);
        const auto where = place(from.depth_offset, name);
        const fresco::Raster16 depth = index_.depth_form == DepthForm::raw
                                           ? raw<std::uint16_t>(bytes, index_.depth, 1, where)
                                           : unpack_depth(bytes, index_.depth.width, index_.depth.height, where);
        auto file = folder_ / (name + ".depth.png");
        fresco::write_file(file, images_.encode_png(depth));
        return file;
    }

    const SensFile& file_;
    const SensIndex& index_;
    const fresco::ImageIo& images_;
    const fs::path& folder_;
    fresco::Intrinsics color_;
    fresco::Intrinsics depth_;
    fresco::RigidTransform depth_from_color_;
};

}  // namespace

SensFrames extract_frames(const SensFile& file, const SensIndex& index, int every, const fresco::ImageIo& images,
                          const fs::path& folder, fresco::Progress& progress)
{
    const Extractor extractor(file, index, images, folder);
    const auto step = static_cast<std::size_t>(every);
    std::vector<std::optional<fresco::Frame>> made((index.frames.size() + step - 1) / step);
    std::atomic<std::size_t> done{0};
    fresco::parallel_for(made.size(), 1, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             for (std::size_t i = begin; i < end; ++i)
                             {
                                 progress.check_canceled();
                                 made[i] = extractor.extract(i * step);
                                 progress.progress(static_cast<double>(++done), static_cast<double>(made.size()), "frames");
                             }
                         });
    SensFrames result;
    for (auto& frame : made)
        if (frame)
            result.frames.frames.push_back(std::move(*frame));
    result.not_tracked = made.size() - result.frames.frames.size();
    if (result.frames.frames.empty())
        throw fresco::Error(file.path().string() + ": none of the " + std::to_string(made.size()) +
                            " frames has a finite pose: the recorder never knew where it was, this recording cannot be used");
    return result;
}

}  // namespace sens
