#pragma once

#include "written_files.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// The folders that the released training code of StyleMesh (CVPR 2022) reads for a scene of ScanNet; README.md lists them.
class StylemeshLayout
{
  public:
    /// `frame_of`: the frame of each view. Throws Error unless all views have the same color intrinsics, for which the layout
    /// has one file, and unless the scene's name has two parts ("scene0000_00"). Keeps references.
    StylemeshLayout(std::string scene, const fresco::UvMaps& maps, const fresco::Frames& frames,
                    const std::vector<std::size_t>& frame_of);

    /// The recorder's number of each view where these are unique and not negative, and else its position: files are named so.
    long number(std::size_t view) const { return numbers_[view]; }

    /// Picture, pose, depth (the sensor's where every frame has it, and else the mesh's), cosine, and one uv map per height.
    WrittenFiles write_view(const std::filesystem::path& folder, std::size_t view, const fresco::ImageIo& images) const;
    /// Intrinsics and the mesh; not thread-safe with itself.
    WrittenFiles write_scene(const std::filesystem::path& folder, const fresco::Mesh& mesh) const;

  private:
    const fresco::Frame& frame(std::size_t view) const { return frames_.frames[frame_of_[view]]; }
    /// Below the scene's folder of images; `folder`: "pose", …
    std::string file(const std::string& folder, std::size_t view, const std::string& extension) const;

    std::string scene_;
    const fresco::UvMaps& maps_;
    const fresco::Frames& frames_;
    const std::vector<std::size_t>& frame_of_;
    std::vector<long> numbers_;
    bool has_sensor_depth_ = true;
};
