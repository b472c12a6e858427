#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <cstdint>
#include <vector>

/// Whether a pixel of a mask is in its region: its channels are bright in the mean.
bool is_in_mask(const fresco::Raster8& mask, int x, int y);

/// The face whose front a camera sees at the center of each pixel: width x height, Hit::none where it sees none. The same for
/// any number of threads.
std::vector<std::uint32_t> faces_in_sight(const fresco::raycast::Scene& scene, const fresco::Camera& camera,
                                          const fresco::Progress& progress);

/// The pixels of each face that masks have in a region, and all of them.
class Votes
{
  public:
    Votes(std::size_t regions, std::size_t faces) : inside_(regions, std::vector<std::uint32_t>(faces)), seen_(inside_) {}

    /// `faces`: as faces_in_sight gives them for the mask's frame.
    void add(std::size_t region, const fresco::Raster8& mask, const std::vector<std::uint32_t>& faces);

    /// F: the region that the largest share of the face's pixels are in, of equal ones the first; regions.size() where that share
    /// is less than `least_share`, or no mask's frame shows the face.
    std::vector<std::uint32_t> winners(double least_share) const;
    /// Whether a mask's frame shows the face.
    bool is_seen(std::size_t face) const;

  private:
    std::vector<std::vector<std::uint32_t>> inside_;
    std::vector<std::vector<std::uint32_t>> seen_;
};
