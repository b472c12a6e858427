#pragma once

#include <fresco/raycast/scene.h>
#include <fresco/uv_mapping/uv_mapper.h>

/// Finds what pixels see by casting the ray of every pixel centre.
class RayFinder final : public fresco::FaceFinder
{
  public:
    /// The mesh must have passed check_mesh and must outlive the finder. Throws Error if Embree reports one (memory).
    explicit RayFinder(const fresco::Mesh& mesh) : scene_(mesh) {}

    void find(std::span<const fresco::Camera> cameras, const fresco::Progress& progress,
              std::span<fresco::FaceMap> faces) override;

  private:
    fresco::raycast::Scene scene_;
};
