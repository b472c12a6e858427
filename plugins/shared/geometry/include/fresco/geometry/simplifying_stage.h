#pragma once

#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <cstddef>

namespace fresco::geometry
{

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
