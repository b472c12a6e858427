#pragma once

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/uv_mapping/shading.h>

#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace fresco
{

/// Finds the face that each pixel sees: rendering::RasterFinder, and its twin in tests/uv_maps that casts rays. A ray ends on the
/// first face it meets in front of the camera, on whichever side and however near; one on a shared edge on exactly one of its
/// faces.
class FaceFinder
{
  public:
    virtual ~FaceFinder();

    /// Fills `faces[i]`, which has the size of `cameras[i]`. The cameras are one camera at several sizes. Uses progress.threads()
    /// threads; the result does not depend on their number. Throws Canceled. Not to be called by two threads at once.
    virtual void find(std::span<const Camera> cameras, const Progress& progress, std::span<FaceMap> faces) = 0;
};

struct CountedUvMap
{
    UvMap map;
    PixelCounts counts;
};

/// Makes the uv maps of one mesh, a camera at a time. Keeps the memory of the last camera's maps for the next.
class UvMapper
{
  public:
    /// The mesh needs texcoords, must have passed check_mesh and must outlive the mapper. `finder` finds faces of that mesh.
    UvMapper(const Mesh& mesh, std::unique_ptr<FaceFinder> finder);

    /// One map per height, of the width Intrinsics::width_at, intrinsics scaled per axis; there until the next call. Rows are
    /// shared among progress.threads() threads; the maps do not depend on their number. `mask` (see load_mask) takes pixels out
    /// of all of them. Throws Canceled.
    const std::vector<CountedUvMap>& make(const Camera& camera, std::span<const int> heights_px, const Progress& progress,
                                          const Raster8& mask = {});

  private:
    struct Rows
    {
        std::size_t map;
        int first;
        int end;
    };

    void resize(const Camera& camera, std::span<const int> heights_px);

    FaceShader shader_;
    std::unique_ptr<FaceFinder> finder_;
    std::vector<Camera> cameras_;
    std::vector<FaceMap> faces_;
    std::vector<RasterF> met_;
    std::vector<CountedUvMap> maps_;
    std::vector<Rows> blocks_;  ///< Blocks of rows of all maps.
    std::vector<PixelCounts> block_counts_;
};

/// Checks the inputs of stages that show a mesh as color cameras see it, named 'mesh' and 'frames'. Throws Error: a mesh that
/// check_mesh refuses, or without texcoords (`wire`: what to wire); no frames; a color camera that check_camera refuses.
void check_viewed(const Mesh& mesh, const Frames& frames, std::string_view wire);

/// check_viewed for stages that make uv maps. Throws Error also for texcoords outside [0,1] (the face is named).
void check_uv_mapping_inputs(const Mesh& mesh, const Frames& frames);

}  // namespace fresco
