#pragma once

#include <fresco/frames.h>
#include <fresco/stage.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <memory>
#include <vector>

namespace fresco
{

/// What the makers of uv maps ask of their inputs, named 'mesh' and 'frames'. Throws Error: a mesh that check_mesh refuses,
/// without texcoords or with some outside [0,1] (the face is named); no frames; a color camera that check_camera refuses.
void check_uv_mapping_inputs(const Mesh& mesh, const Frames& frames);

/// A stage with the ports, options and report of `uvmaps.raycast`: checks its inputs, makes the uv maps of every frame at every
/// height from the faces that `finder` finds, and counts what became of the pixels. A way of making uv maps derives from it and
/// needs no more than `finder` and its costs.
class UvMappingStage : public Stage
{
  public:
    void run(RunContext& run) final;

  protected:
    /// Prepared for the mesh, which has faces and texcoords and outlives it.
    virtual std::unique_ptr<FaceFinder> finder(const Mesh& mesh, const RunContext& run) const = 0;

  private:
    Input<Mesh> mesh_{this, "mesh", "Triangle mesh with texcoords, as an atlas.* stage makes it"};
    Input<Frames> frames_{this, "frames", "The views; their color cameras and masks are used"};
    Output<UvMaps> uvmaps_{this, "uvmaps", "Per pixel: texcoord, depth, cosine of the viewing angle, validity"};
    Option<std::vector<int>> heights_px_{this, "heights_px", {256}, range(16, 4096), "Heights of the maps; widths follow"};
    enum class Normals
    {
        smooth,
        face
    };
    Choice<Normals> normals_{
        this,
        "normals",
        Normals::smooth,
        {{"smooth", Normals::smooth}, {"face", Normals::face}},
        "Normals that angles are measured from: of the vertices, interpolated, or of the faces, as StyleMesh's "
        "released renderer for ScanNet has them"};
};

}  // namespace fresco
