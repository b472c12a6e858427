#pragma once

#include <fresco/camera.h>
#include <fresco/math.h>
#include <fresco/recordings/lens.h>
#include <fresco/recordings/recorded_view.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Reads a reconstruction of COLMAP: parses its two files, text or binary, and turns them into recorded views. The stage
/// finds the files; the fuzzer calls the parsers.

namespace colmap
{

/// A camera of a reconstruction.
struct ModelCamera
{
    fresco::Intrinsics intrinsics;
    fresco::recordings::Lens lens;
    bool is_panorama = false;  ///< Only the size of the intrinsics is set.
    std::string source;        ///< Its place in the file, for errors.
};

/// A supported camera model of COLMAP, with the names of its parameters in order.
struct CameraModel
{
    std::int32_t id;
    std::string_view name;
    std::vector<std::string_view> parameters;
    bool is_fisheye = false;
};

/// Throws Error naming `place` and the supported models for any other model.
const CameraModel& camera_model(std::string_view name, const std::string& place);
const CameraModel& camera_model(std::int32_t id, const std::string& place);

/// The camera of a model's parameters, in COLMAP's order. Throws Error naming `place` if the size is not 1 to 65536 pixels, or
/// for a wrong number of parameters or one that is not finite.
ModelCamera model_camera(const CameraModel& model, std::uint64_t width, std::uint64_t height,
                         const std::vector<double>& parameters, std::string place);

using Cameras = std::map<std::int64_t, ModelCamera>;  ///< By id.

/// A picture that COLMAP placed. Its points are not kept.
struct ModelImage
{
    fresco::RigidTransform world_from_camera;
    std::int64_t camera = 0;  ///< Id.
    std::string name;         ///< Path below the folder of pictures.
    std::string source;       ///< Its place in the file, for errors.
};

/// Parse cameras.txt and images.txt. Skip comments, but check the counts that COLMAP writes in them. Throw Error "source:line:
/// …", also for a truncated file.
Cameras parse_cameras_text(std::string_view text, std::string_view source);
std::vector<ModelImage> parse_images_text(std::string_view text, std::string_view source);

/// Parse cameras.bin and images.bin, little-endian. Allocate no more than the file holds, whatever its counts say. Throw Error
/// "source: byte offset: …", also for a truncated file and for bytes after its end.
Cameras parse_cameras_binary(std::span<const std::byte> bytes, std::string_view source);
std::vector<ModelImage> parse_images_binary(std::span<const std::byte> bytes, std::string_view source);

struct ViewOptions
{
    std::filesystem::path pictures;  ///< Folder of the pictures.
    std::filesystem::path depth;     ///< Folder of depth pictures named like them, ending in .png; empty: none.
    std::filesystem::path masks;  ///< Folder of masks: a picture's name with .png added, or in place of its ending; empty: none.
};

/// The views of the images, by name. Throws Error naming the image's place if its camera is not among `cameras`, or if there are
/// no images.
std::vector<fresco::recordings::RecordedView> model_views(const Cameras& cameras, const std::vector<ModelImage>& images,
                                                          const std::filesystem::path& images_file, const ViewOptions& options);

}  // namespace colmap
