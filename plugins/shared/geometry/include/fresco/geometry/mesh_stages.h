#pragma once

#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <cstddef>

/// \file What several stages share: the atlas of projected charts, which those that make or complete an atlas call, and the base
/// of those that decimate.

namespace fresco::geometry
{

struct AtlasOptions
{
    double angle_limit_deg = 70;
    double merge_limit_deg = 80;
    int size_px = 2048;
};

/// Returns the mesh with charts that are projected and packed; reports figures. Throws Error for a mesh without area, Canceled.
Mesh projected_atlas(const Mesh& mesh, const AtlasOptions& options, RunContext& run);

/// A stage with the ports and options of `mesh.decimate`: repairs the mesh, has it simplified, reports both sides, and warns
/// where the target or a component was missed. A simplifier derives from it and needs no more than `simplify` and its costs.
class SimplifyingStage : public Stage
{
  public:
    void run(RunContext& run) final;

  protected:
    /// At most `max_faces` of a manifold mesh that has more (see repair.h); more only where a component would vanish.
    virtual Mesh simplify(const Mesh& mesh, std::size_t max_faces, RunContext& run) const = 0;

  private:
    Input<Mesh> mesh_{this, "mesh", "Triangle mesh to simplify"};
    Output<Mesh> simplified_{this, "simplified", "The same surface with fewer triangles"};
    Option<int> max_faces_{this, "max_faces", 500'000, range(4, 50'000'000), "Stop at this many triangles"};
};

}  // namespace fresco::geometry
