#pragma once

#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/parallel.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// \file Finds masks in a folder and lets their pixels vote on the region of each face. The stage turns the winners into regions.

struct MaskedRegion
{
    std::string name;
    std::map<std::size_t, std::filesystem::path> mask_of_frame;  ///< By the frame's index.
};

/// The files REGION/FRAME.png or .jpg below a folder, where FRAME is a frame's name or <sequence>_<name>; skips other
/// entries, and those that begin with '.'. Throws Error naming the file for a picture without a frame, two pictures of one frame,
/// and a name that occurs in several sequences; MissingInput for a folder without masks.
std::vector<MaskedRegion> find_masks(const std::filesystem::path& folder, const std::vector<fresco::Frame>& frames);

/// The face whose front a camera sees at the center of each pixel, no_face for pixels without one. `finder` is of the mesh. The
/// same for any number of threads.
fresco::FaceMap faces_in_sight(const fresco::Mesh& mesh, fresco::FaceFinder& finder, const fresco::Camera& camera,
                               const fresco::Progress& progress);

/// Counts the pixels of each face inside of a region's masks, and all of them.
class Votes
{
  public:
    Votes(std::size_t regions, std::size_t faces) : inside_(regions, std::vector<std::uint32_t>(faces)), seen_(inside_) {}

    /// `faces`: faces_in_sight of the mask's frame.
    void add(std::size_t region, const fresco::Raster8& mask, const fresco::FaceMap& faces);

    /// F: the region with the largest share of the face's pixels, the first of equals; the number of regions if that share is
    /// less than half, or if no mask's frame shows the face.
    std::vector<std::uint32_t> winners() const;
    /// Whether a mask's frame shows the face.
    bool is_seen(std::size_t face) const;

  private:
    std::vector<std::vector<std::uint32_t>> inside_;
    std::vector<std::vector<std::uint32_t>> seen_;
};
