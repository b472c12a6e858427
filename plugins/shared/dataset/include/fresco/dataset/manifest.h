#pragma once

#include <fresco/camera.h>
#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file The manifest of a prepared dataset, dataset.json; plugins/dataset/write/README.md describes the folder.

namespace fresco::dataset
{

inline constexpr std::string_view manifest_name = "dataset.json";
inline constexpr std::string_view mesh_name = "mesh.ply";
inline constexpr std::string_view style_name = "style.npy";

/// How texcoords are stored: as they are, or as round(65535 u).
enum class UvType
{
    float32,
    uint16
};

/// One recorded view.
struct View
{
    std::string sequence;
    std::string frame;
    std::int64_t number = 0;                 ///< The recorder's frame number.
    Camera color;                            ///< At full size.
    Camera depth;                            ///< The recorder's depth camera.
    std::optional<double> depth_unit_m;      ///< Meters per step of its picture; nothing without one.
    double sharpness = 0;                    ///< fresco::sharpness at 320 x 240.
    std::vector<std::int64_t> valid_pixels;  ///< Per height.
};

/// Contents of a file.
struct FileStamp
{
    std::uint64_t bytes = 0;
    std::string hash;  ///< content_hash
    friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

/// How well the pictures and the mesh fit, as frames.align measured it before and after it corrected the cameras.
struct Agreement
{
    double error_before = 0;  ///< Mean difference of log brightness between views of a point, exposures removed.
    double error_after = 0;
    double median_moved_px = 0;  ///< Median of how far the frames' pictures moved on the surface.
    double most_moved_px = 0;
    friend bool operator==(const Agreement&, const Agreement&) = default;
};
/// An object with these entries.
Value to_value(const Agreement& agreement);

struct Manifest
{
    std::string writer;  ///< Program that wrote it, "fresco 0.1.0"; may be empty.
    UvType uv = UvType::float32;
    std::vector<int> heights_px;  ///< Ascending.
    bool has_style = false;
    std::optional<Agreement> agreement;  ///< Missing if not measured.
    std::vector<View> views;
    std::map<std::string, FileStamp>
        files;  ///< By name, relative to the dataset's folder and '/'-separated; all but the manifest.
};

/// "views/000012/uv_256.npy": quantity is uv, depth, cosine, valid or color.
std::string map_name(std::size_t view, std::string_view quantity, int height_px);
/// "views/000012/color.npy", the camera picture at full size.
std::string picture_name(std::size_t view);
/// "views/000012/sensor_depth.npy"
std::string sensor_depth_name(std::size_t view);

/// The names of the files that a dataset with this manifest has at least, whatever it lists.
std::vector<std::string> needed_files(const Manifest& manifest);

/// [{name, bytes, hash}, …], by name.
Value stamps_value(const std::map<std::string, FileStamp>& files);

/// JSON text; equal manifests give equal bytes.
std::string to_text(const Manifest& manifest);

/// Strict: throws Error naming `source`, the entry and what was expected for text that is no JSON, another format or version,
/// other conventions, missing, unknown or mistyped entries, numbers out of range, cameras that check_camera refuses, names that
/// lead out of the folder or stand twice, and a file that a view needs and that is not listed.
Manifest parse_manifest(std::string_view text, std::string_view source);

}  // namespace fresco::dataset
