#pragma once

#include <fresco/geometry/flatten.h>
#include <fresco/stage.h>

namespace fresco::geometry
{

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
    Option<int> gutter_px_{this, "gutter_px", 4, range(0, 64), "Texels between charts at size_px"};
};

}  // namespace fresco::geometry
