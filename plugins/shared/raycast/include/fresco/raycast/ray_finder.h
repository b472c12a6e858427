#pragma once

#include <fresco/raycast/scene.h>
#include <fresco/uv_mapping/uv_mapper.h>

namespace fresco::raycast
{

/// Finds what pixels see by casting the ray of every pixel center.
class RayFinder final : public FaceFinder
{
  public:
    /// The mesh must have passed check_mesh and must outlive the finder. Throws Error if Embree reports one (memory).
    explicit RayFinder(const Mesh& mesh) : scene_(mesh) {}

    void find(std::span<const Camera> cameras, const Progress& progress, std::span<FaceMap> faces) override;

  private:
    Scene scene_;
};

}  // namespace fresco::raycast
