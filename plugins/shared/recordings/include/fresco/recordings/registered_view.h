#pragma once

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/progress.h>
#include <fresco/recordings/lens.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file Views of one camera: recordings whose depth pictures, if there are any, were brought into the color camera.
namespace fresco::recordings
{

/// One view as its recording tells it.
struct RegisteredView
{
    std::string sequence;  ///< File-name safe.
    std::string name;      ///< File-name safe, unique in its sequence.
    long number = 0;
    std::filesystem::path color;
    std::filesystem::path depth;  ///< Empty: none. Of any size, the camera's shape and field of view.
    Intrinsics camera;            ///< Of the color picture.
    Lens lens;
    RigidTransform world_from_camera;
    double depth_unit_m = 0.001;
    std::string source;  ///< What told the camera and the pose, such as "traj.txt:3", for errors.
};

/// Names of a picture as its recording lists it ("images/frame_00012.jpg"): sequence "images" ("scan" without a folder), name
/// "frame_00012", other characters than letters, digits and -_. as '_'.
void name_by_picture(RegisteredView& view, const std::filesystem::path& listed);

/// Sorts by sequence and name, digits as numbers, and numbers the views: by the last number of their names where these are unique
/// in each sequence, else by their place in the order.
void order_by_name(std::vector<RegisteredView>& views);

/// Keeps every `every`-th view, from the first on.
void keep_every(std::vector<RegisteredView>& views, int every);

/// Frames of the views, in their order. Pictures without a lens to undo stay where they are: paths and content hashes, their
/// files walked to the end. Others are undistorted into `folder`: <sequence>/<name>.color.jpg (quality 95) and .depth.png; each
/// thread holds one picture. A view without depth gives a frame without; its depth camera is the color camera.
/// Throws MissingInput that names the pictures that are not there; Error naming the file or `source`: a picture that is cut or of
/// another size than its camera, a depth picture that is not 16-bit gray or of another shape, a color picture that EXIF turns, a
/// camera or pose that check_camera refuses, two views of one name.
Frames registered_frames(const std::vector<RegisteredView>& views, const ImageIo& images, const std::filesystem::path& folder,
                         Progress& progress);

}  // namespace fresco::recordings
