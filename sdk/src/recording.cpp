#include <fresco/recording.h>

#include <fresco/error.h>
#include <fresco/hash.h>
#include <fresco/parallel.h>
#include <fresco/value.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace fresco
{
namespace
{

constexpr std::size_t files_named = 5;

std::string size_text(int width, int height)
{
    return std::to_string(width) + "x" + std::to_string(height);
}

void check_size(const std::filesystem::path& file, ImageHeader header, const Intrinsics& expected)
{
    if (header.width != expected.width || header.height != expected.height)
        throw Error(file.string() + ": the picture is " + size_text(header.width, header.height) + ", the scan's first is " +
                    size_text(expected.width, expected.height) + "; all pictures of one camera must have one size");
}

Frame make_frame(const ViewFiles& files, const RecorderCameras& cameras, const RigidTransform& world_from_depth,
                 const ImageIo& images)
{
    const auto color = images.check(files.color);
    check_size(files.color, color, cameras.color);
    check_not_turned(files.color, color, files.pose.string());
    const auto depth = images.check(files.depth);
    check_size(files.depth, depth, cameras.depth);
    check_depth_kind(files.depth, depth);
    Frame frame;
    frame.sequence = files.sequence;
    frame.name = files.name;
    frame.number = files.number;
    frame.color = {cameras.color, world_from_depth * cameras.depth_from_color};
    frame.depth = {cameras.depth, world_from_depth};
    frame.color_picture = {std::filesystem::absolute(files.color), file_hash(files.color)};
    frame.depth_picture = {std::filesystem::absolute(files.depth), file_hash(files.depth)};
    check_camera(frame.color, files.pose.string());
    check_camera(frame.depth, files.pose.string());
    return frame;
}

}  // namespace

void refuse_missing(const std::vector<std::string>& missing, std::string_view rule)
{
    if (missing.empty())
        return;
    std::string text = std::to_string(missing.size()) + (missing.size() == 1 ? " file is missing:" : " files are missing:");
    for (std::size_t i = 0; i < std::min(missing.size(), files_named); ++i)
        text += (i == 0 ? " " : ", ") + missing[i];
    if (missing.size() > files_named)
        text += ", …";
    throw MissingInput(text + "; " + std::string(rule));
}

void check_center(const Intrinsics& k, const std::string& source, const std::filesystem::path& picture)
{
    if (k.cx <= 0 || k.cy <= 0 || k.cx >= k.width || k.cy >= k.height)
        throw Error(source + ": the center (" + to_json(k.cx) + ", " + to_json(k.cy) + ") is outside of " + picture.string() +
                    ", which is " + size_text(k.width, k.height) + "; set intrinsics for pictures of this size");
}

void check_not_turned(const std::filesystem::path& file, const ImageHeader& header, const std::string& source)
{
    if (header.orientation != 1)
        throw Error(file.string() + ": its EXIF data says that it is to be turned (orientation " +
                    std::to_string(header.orientation) + "), but " + source +
                    " means the pixels as they are stored; remove the tag (exiftool -Orientation= FILE)");
}

void check_depth_kind(const std::filesystem::path& file, const ImageHeader& header)
{
    if (header.bits > 0 && (header.bits != 16 || !header.gray))
        throw Error(file.string() + ": expected a depth picture, a PNG of one channel of 16 bits; this one has " +
                    std::to_string(header.bits) + " bits" + (header.gray ? "" : " and colors"));
}

Frames posed_frames(const std::vector<ViewFiles>& views, const RecorderCameras& cameras, const PoseReader& read_pose,
                    const ImageIo& images, Progress& progress)
{
    std::vector<std::optional<Frame>> made(views.size());
    std::atomic<std::size_t> done{0};
    parallel_for(views.size(), 4, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                     {
                         progress.check_canceled();
                         if (const auto pose = read_pose(views[i]))
                             made[i] = make_frame(views[i], cameras, *pose, images);
                         progress.progress(static_cast<double>(++done), static_cast<double>(views.size()), "frames");
                     }
                 });
    Frames frames;
    for (auto& frame : made)
        if (frame)
            frames.frames.push_back(std::move(*frame));
    return frames;
}

}  // namespace fresco
