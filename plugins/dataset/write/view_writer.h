#pragma once

#include <fresco/dataset/manifest.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/uv_maps.h>
#include <fresco/value.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

/// \file Writes the files of one view of a dataset: uv maps, pictures, and the picture files and transforms.json for other
/// programs. The stage calls write_view() for all views in parallel; the StyleMesh layout (stylemesh_layout.h) uses parts of it.

/// The files of one view, by name relative to the dataset's folder.
struct WrittenFiles
{
    std::map<std::string, fresco::dataset::FileStamp> files;
    double sharpness = 0;  ///< fresco::sharpness at 320 x 240 of the camera picture.

    std::vector<std::string> names() const;
    /// Writes a file of it below the dataset's folder, with the folders that its name has.
    void write(const std::filesystem::path& folder, const std::string& name, std::span<const std::byte> bytes);
};

/// For the note that keeps a finished view in an interrupted run, and back.
fresco::Value to_value(const WrittenFiles& written);
WrittenFiles written_files_from(const fresco::Value& value);

struct EncodedPicture
{
    std::string extension;  ///< ".png" or ".jpg"
    std::vector<std::byte> bytes;
};

/// The camera picture of a frame as other programs read it: the recorder's own file, byte for byte, if it is JPEG or an 8-bit RGB
/// PNG; else (16 bits, gray, a palette or alpha) `picture` as PNG. Throws Error if the file changed since it was listed.
EncodedPicture encoded_color(const fresco::Frame& frame, const fresco::Raster8& picture, const fresco::ImageIo& images);

/// 16-bit PNG in millimeters, 0 = no depth; depths beyond 65.534 m become 0. `depth`: H x W, meters.
std::vector<std::byte> encoded_depth(const fresco::RasterF& depth, const fresco::ImageIo& images);

inline constexpr const char* transforms_name = "transforms.json";

/// "images/000012.jpg": the picture of a view for other programs, with its extension.
std::string image_name(std::size_t view, const std::string& extension);
/// "depth/000012.png"
std::string depth_image_name(std::size_t view);

/// nerfstudio's transforms.json of all views, whose pictures must be among the manifest's files: pinhole intrinsics per frame,
/// poses with OpenGL camera axes, depth in millimeters in the color camera.
std::string transforms_text(const fresco::dataset::Manifest& manifest);

/// As fresco::frames_of_views; also throws Error for a frame that occurs twice or whose color camera differs from its view's.
std::vector<std::size_t> checked_frames(const fresco::UvMaps& maps, const fresco::Frames& frames);

/// A map that passed fresco::dataset's checks. Throws Error naming the view, the height and the pixel.
fresco::UvMap checked_map(const fresco::UvMaps& maps, std::size_t view, std::size_t level);

struct ViewOptions
{
    fresco::dataset::UvType uv;
    bool pictures;  ///< Also the camera picture and the mesh's depth (of the largest height) as picture files.
};

/// Writes the files of one view below `folder`: its uv map and camera picture at each height, resized as in the optimizer; the
/// camera picture at full size; the depth camera's picture, if any. Holds one height at a time. Thread-safe for different views.
/// `images` may be null if every picture is NPY and no picture files are written. Throws Error naming the file or the map if it
/// cannot be read, and for values that fresco::dataset's checks refuse.
WrittenFiles write_view(const std::filesystem::path& folder, const fresco::UvMaps& maps, std::size_t view,
                        const fresco::Frame& frame, const fresco::ImageIo* images, const ViewOptions& options);

/// The view's entry in the manifest.
fresco::dataset::View view_entry(const fresco::UvMaps& maps, std::size_t view, const fresco::Frame& frame,
                                 const WrittenFiles& written);
