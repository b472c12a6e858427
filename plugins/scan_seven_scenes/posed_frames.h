#pragma once

#include "calibration.h"
#include "scan_folder.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/progress.h>

/// Poses, cameras and content hashes of the listed frames, in their order. All color pictures have one size, all depth pictures
/// have one size (read from the headers).
/// world_from_depth = the pose file; world_from_color = world_from_depth * inverse(color_from_depth).
/// Throws Error naming the file: a pose that is no rigid transform, a picture of another size or that EXIF turns, intrinsics
/// whose center is outside the picture (they are for another size).
fresco::Frames posed_frames(const ScanFolder& scan, const Calibration& calibration, const fresco::ImageIo& images,
                            fresco::Progress& progress);
