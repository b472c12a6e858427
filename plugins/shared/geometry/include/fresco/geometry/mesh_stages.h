#pragma once

#include <fresco/geometry/flatten.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <cstddef>
#include <functional>

/// \file The bases of stages that make an atlas and of stages that decimate: ports, options and reports are theirs, a plugin adds
/// its algorithm.

namespace fresco::geometry
{

struct AtlasOptions
{
    double angle_limit_deg = 70;
    double merge_limit_deg = 80;
    int size_px = 2048;
};

/// Returns the mesh with charts that are projected, laid flat by `lay_flat` where that is given, and packed; reports figures.
/// Throws Error for a mesh without area, Canceled.
Mesh projected_atlas(const Mesh& mesh, const AtlasOptions& options, RunContext& run,
                     const std::function<void(const Surface&, FlatCharts&, const FlattenOptions&)>& lay_flat = {});

/// A stage with the ports and options of `atlas.project`: cuts the mesh into charts, lays each flat by projection, packs them and
/// reports figures. A parametrizer derives from it and needs no more than `lay_flat` and its costs.
class AtlasStage : public Stage
{
  public:
    void run(RunContext& run) final;

  protected:
    /// See LayFlat; nothing by default.
    virtual void lay_flat(const Surface& surface, FlatCharts& flat, const FlattenOptions& options, RunContext& run) const;

  private:
    Input<Mesh> mesh_{this, "mesh", "Triangle mesh; existing texture coordinates are replaced"};
    Output<Mesh> atlas_{this, "atlas", "The same mesh with texture coordinates and charts"};
    Option<double> angle_limit_deg_{this, "angle_limit_deg", 70.0, range(1, 89),
                                    "Largest angle between the smoothed surface normal and the direction of the chart"};
    Option<double> merge_limit_deg_{this, "merge_limit_deg", 80.0, range(1, 89),
                                    "The same for single faces: tiny charts join a neighbor up to this angle"};
    Option<int> size_px_{this, "size_px", 2048, range(64, 16384),
                         "Texels per side of the texture: uv maps and what paints take it from the atlas"};
};

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
