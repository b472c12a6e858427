#include "posed_frames.h"

#include <fresco/recording.h>

fresco::Frames posed_frames(const ScanFolder& scan, const Calibration& calibration, const fresco::ImageIo& images,
                            fresco::Progress& progress)
{
    const auto& first = scan.frames.at(0);
    const auto color_size = images.header(first.color);
    const auto depth_size = images.header(first.depth);
    const fresco::RecorderCameras cameras{color_intrinsics(calibration, color_size.width, color_size.height),
                                          depth_intrinsics(calibration, depth_size.width, depth_size.height),
                                          calibration.color_from_depth.inverse()};
    fresco::check_center(cameras.color, calibration.color_source, first.color);
    fresco::check_center(cameras.depth, calibration.depth_source, first.depth);
    return fresco::posed_frames(
        scan.frames, cameras, [](const fresco::ViewFiles& view) { return fresco::read_rigid_transform(view.pose); }, images,
        progress);
}
