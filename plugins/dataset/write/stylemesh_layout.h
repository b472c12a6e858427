#pragma once

#include "view_writer.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// \file The second layout of the stage, chosen by `layout: stylemesh`.

/// The folders that the released training code of StyleMesh (CVPR 2022) reads for a scene of ScanNet; README.md lists them.
class StylemeshLayout
{
  public:
    /// `frame_of`: the frame of each view. Throws Error if color intrinsics differ between views, because the layout has one file
    /// for them, and if the scene's name does not have two parts ("scene0000_00"). Keeps references.
    StylemeshLayout(std::string scene, const fresco::UvMaps& maps, const fresco::Frames& frames,
                    const std::vector<std::size_t>& frame_of);

    /// The number in a view's file names: the recorder's if these are unique and not negative, else its position.
    long number(std::size_t view) const { return numbers_[view]; }

    /// Picture and the sensor's depth, in the size in which the released preparation exports them, pose, cosine, and one uv map
    /// per height; the mesh's depth where some frame has no sensor's.
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
