#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>

#include <cstddef>
#include <memory>

struct FusionOptions
{
    double voxel_m;       ///< Side of a voxel.
    double truncation_m;  ///< How far from a measured surface its distance is kept, to both sides.
};

/// A volume of truncated signed distances, averaged over all depth pictures, in blocks of 16^3 voxels where a surface was seen;
/// Open3D's ScalableTSDFVolume. Curless and Levoy, "A volumetric method for building complex models from range images" (1996).
/// Used by one thread at a time; the same calls give the same mesh.
class Fusion
{
  public:
    explicit Fusion(const FusionOptions& options);
    ~Fusion();
    Fusion(const Fusion&) = delete;
    Fusion& operator=(const Fusion&) = delete;

    /// `depth`: H x W, meters along the optical axis, 0 = none; `colors`: H x W x 3. Of the camera's size both.
    void add(const fresco::RasterF& depth, const fresco::Raster8& colors, const fresco::Camera& camera);
    /// What the volume takes by now.
    std::size_t bytes() const;
    /// Whether it takes at most so much once this picture is added: a single one can open blocks of many gigabytes. Holds no more
    /// than the limit itself while it counts.
    bool fits(const fresco::RasterF& depth, const fresco::Camera& camera, std::size_t limit_bytes) const;
    /// The surface (marching cubes) with vertex colors, faces counter-clockwise as the cameras saw them; empty where nothing was
    /// seen.
    fresco::Mesh mesh() const;

  private:
    struct Volume;
    std::unique_ptr<Volume> volume_;
};

const char* open3d_version();
