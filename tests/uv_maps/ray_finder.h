#pragma once

#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <vector>

/// The twin of rendering::RasterFinder: finds what pixels see by casting the ray of every pixel center.
class RayFinder final : public fresco::FaceFinder
{
  public:
    /// The mesh must have passed check_mesh and must outlive the finder.
    explicit RayFinder(const fresco::Mesh& mesh) : scene_(mesh) {}

    void find(std::span<const fresco::Camera> cameras, const fresco::Progress& progress,
              std::span<fresco::FaceMap> faces) override
    {
        for (std::size_t i = 0; i < cameras.size(); ++i)
            fresco::parallel_for(static_cast<std::size_t>(faces[i].height), 16, progress,
                                 [&](std::size_t begin, std::size_t end)
                                 {
                                     progress.check_canceled();
                                     const auto width = static_cast<std::size_t>(faces[i].width);
                                     std::vector<fresco::raycast::Hit> hits((end - begin) * width);
                                     scene_.cast_rows(cameras[i], static_cast<int>(begin), static_cast<int>(end), hits);
                                     for (std::size_t pixel = 0; pixel < hits.size(); ++pixel)
                                         faces[i].values[begin * width + pixel] = hits[pixel].triangle;
                                 });
    }

  private:
    fresco::raycast::Scene scene_;
};
