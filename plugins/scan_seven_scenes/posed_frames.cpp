#include "posed_frames.h"

#include <fresco/error.h>
#include <fresco/hash.h>
#include <fresco/parallel.h>

#include <atomic>

namespace
{

std::string size_text(int width, int height)
{
    return std::to_string(width) + "x" + std::to_string(height);
}

void check_size(const std::filesystem::path& file, fresco::ImageHeader header, const fresco::Intrinsics& expected)
{
    if (header.width != expected.width || header.height != expected.height)
        throw fresco::Error(file.string() + ": the picture is " + size_text(header.width, header.height) +
                            ", the scan's first is " + size_text(expected.width, expected.height) +
                            "; all pictures of one camera must have one size");
}

void check_centre(const fresco::Intrinsics& k, const std::string& source, const std::filesystem::path& picture)
{
    if (k.cx <= 0 || k.cy <= 0 || k.cx >= k.width || k.cy >= k.height)
        throw fresco::Error(source + ": the centre (" + std::to_string(k.cx) + ", " + std::to_string(k.cy) + ") is outside of " +
                            picture.string() + ", which is " + size_text(k.width, k.height) +
                            "; give the intrinsics for pictures of this size");
}

fresco::Frame make_frame(const FrameFiles& files, const fresco::Camera& color, const fresco::Camera& depth,
                         const fresco::RigidTransform& depth_from_color, const fresco::ImageIo& images)
{
    check_size(files.color, images.header(files.color), color.intrinsics);
    check_size(files.depth, images.header(files.depth), depth.intrinsics);
    fresco::Frame frame;
    frame.sequence = files.sequence;
    frame.name = files.name;
    frame.number = files.number;
    frame.color = color;
    frame.depth = depth;
    frame.depth.world_from_camera = fresco::read_rigid_transform(files.pose);
    frame.color.world_from_camera = frame.depth.world_from_camera * depth_from_color;
    frame.color_picture = {std::filesystem::absolute(files.color), fresco::file_hash(files.color)};
    frame.depth_picture = {std::filesystem::absolute(files.depth), fresco::file_hash(files.depth)};
    fresco::check_camera(frame.color, files.pose.string());
    fresco::check_camera(frame.depth, files.pose.string());
    return frame;
}

}  // namespace

fresco::Frames posed_frames(const ScanFolder& scan, const Calibration& calibration, const fresco::ImageIo& images,
                            fresco::Progress& progress)
{
    const auto& first = scan.frames.at(0);
    const auto color_size = images.header(first.color);
    const auto depth_size = images.header(first.depth);
    const fresco::Camera color{color_intrinsics(calibration, color_size.width, color_size.height), {}};
    const fresco::Camera depth{depth_intrinsics(calibration, depth_size.width, depth_size.height), {}};
    check_centre(color.intrinsics, calibration.color_source, first.color);
    check_centre(depth.intrinsics, calibration.depth_source, first.depth);
    const auto depth_from_color = calibration.color_from_depth.inverse();

    fresco::Frames frames;
    frames.frames.resize(scan.frames.size());
    std::atomic<std::size_t> done{0};
    fresco::parallel_for(scan.frames.size(), 4, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             for (std::size_t i = begin; i < end; ++i)
                             {
                                 progress.check_cancelled();
                                 frames.frames[i] = make_frame(scan.frames[i], color, depth, depth_from_color, images);
                                 progress.progress(static_cast<double>(++done), static_cast<double>(scan.frames.size()),
                                                   "frames");
                             }
                         });
    return frames;
}
