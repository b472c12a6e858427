#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>

#include "bake.h"

#include <string>
#include <vector>

using namespace fresco;

namespace
{
class TextureBake final : public Stage
{
    Input<Texture> texture{this, "texture", "The texture; the picture gets its size"};
    Input<Mesh> mesh{this, "mesh", "The mesh whose texcoords the texture was made for"};
    Output<TexturedMesh> textured_mesh{this, "textured_mesh", "The mesh with its 8-bit picture"};
    Choice<Unseen> unseen{this,
                          "unseen",
                          Unseen::fill,
                          {{"fill", Unseen::fill}, {"keep", Unseen::keep}},
                          "Texels that no frame saw: fill from the seen surface around them, or keep what the texture holds"};

    void run(RunContext& run) override
    {
        texturing::check_has_atlas(*mesh, "the mesh on port 'mesh'", "the atlas.* stage that the uv maps were made with");
        check_atlas(texture->atlas, *mesh, "the texture on port 'texture'");
        BakeCounts counts;
        TexturedMesh result;
        result.image = Image(bake(*texture, *mesh, *unseen, counts, run));
        result.mesh = *mesh;
        result.mesh.saved_in = mesh.folder();
        tell(run, counts);
        textured_mesh = std::move(result);
    }

    void tell(RunContext& run, const BakeCounts& counts) const
    {
        const auto total = static_cast<double>(counts.chart_texels);
        const double seen_share = static_cast<double>(counts.seen_texels) / total;
        run.report("chart_texels", counts.chart_texels);
        run.report("chart_share", total / static_cast<double>(texture->seen.values.size()));
        run.report("seen_share", seen_share);
        run.report("filled_share", *unseen == Unseen::keep ? 0.0 : 1 - seen_share);
    }
};
}  // namespace

FRESCO_STAGE("texture.bake", TextureBake, "Collapses the texture's layers into one picture and fills what no frame saw")
