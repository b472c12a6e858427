#pragma once

#include "light.h"
#include "surface_net.h"

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/raster.h>

#include <atomic>
#include <vector>

namespace room
{

/// The surface with a scanner's errors: vertices moved along their normals by slow waves and fine noise of about `noise_m`
/// (standard deviation), and colored as the light shows them.
fresco::Mesh noisy_mesh(const SurfaceNet& net, const Scene& scene, const LightMap& light, float edge, float noise_m,
                        std::uint32_t seed, fresco::Progress& progress);

/// Which vertices the depth camera has seen. `add_view` may be called from several threads at once.
class SeenVertices
{
  public:
    explicit SeenVertices(const std::vector<Vec3f>& positions) : positions_(positions), seen_(positions.size()) {}
    void add_view(const fresco::Raster<float>& exact_depth, const fresco::Camera& camera);
    bool seen(std::size_t vertex) const { return seen_[vertex].load(std::memory_order_relaxed) != 0; }

  private:
    const std::vector<Vec3f>& positions_;
    std::vector<std::atomic<char>> seen_;
};

/// What a scan has of the mesh: faces with a seen vertex, without crumbs of fewer than 40 faces. Throws Error if nothing is left.
/// `parts` are those of the mesh's faces, and of what is left afterward.
fresco::Mesh seen_part(const fresco::Mesh& mesh, const SeenVertices& seen, std::vector<Part>& parts);

/// F: what each face shows, exactly: what two of its corners are part of, or the first.
std::vector<Part> parts_of_faces(const SurfaceNet& net, const Scene& scene);

}  // namespace room
