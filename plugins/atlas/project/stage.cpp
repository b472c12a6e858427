#include <fresco/geometry/mesh_stages.h>
#include <fresco/texture.h>

namespace
{

using namespace fresco;

class AtlasProject final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "Triangle mesh; existing texture coordinates are replaced"};
    Output<Mesh> atlas{this, "atlas", "The same mesh with texture coordinates and charts"};
    Option<double> angle_limit_deg{this, "angle_limit_deg", 70.0, range(1, 89),
                                   "Largest angle between the smoothed surface normal and the direction of the chart"};
    Option<double> merge_limit_deg{this, "merge_limit_deg", 80.0, range(1, 89),
                                   "The same for single faces: tiny charts join a neighbor up to this angle"};
    Option<int> size_px{this, "size_px", 2048, range(64, 16384),
                        "Texels per side of the texture: uv maps and what paints take it from the atlas"};

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the input mesh");
        if (*merge_limit_deg < *angle_limit_deg)
            throw Error("option \"merge_limit_deg\": expected at least angle_limit_deg");
        atlas = geometry::projected_atlas(
            *mesh, {.angle_limit_deg = *angle_limit_deg, .merge_limit_deg = *merge_limit_deg, .size_px = *size_px}, run);
    }
};

}  // namespace

FRESCO_STAGE("atlas.project", AtlasProject, "Atlas of angle-limited projection charts")
