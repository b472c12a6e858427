#include "painted_model.h"

#include <fresco/images/filters.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace export_model
{

namespace
{

/// The pixel at a coordinate of a picture that goes on beyond [0,1].
int wrapped(double at, int size, fresco::Wrap wrap)
{
    if (wrap == fresco::Wrap::mirror)
    {
        at -= 2 * std::floor(at / 2);
        at = at > 1 ? 2 - at : at;
    }
    else if (wrap == fresco::Wrap::repeat)
        at -= std::floor(at);
    return static_cast<int>(std::clamp(at, 0.0, 1 - 0.5 / size) * size);
}

}  // namespace

fresco::Raster8 cutout_alpha(const fresco::Model& model, const std::vector<fresco::Raster8>& pictures, const fresco::Mesh& atlas,
                             const std::vector<bool>& cutout, int size_px, fresco::RunContext& run)
{
    const auto faces = find_texel_faces(atlas, fresco::texturing::find_charts(atlas), size_px, run);
    fresco::RasterF alpha(size_px, size_px, 1, 1.0F);
    fresco::Raster8 covered(size_px, size_px, 1, 0);
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
    {
        const std::uint32_t face = faces.face[texel];
        if (face == fresco::texturing::TexelFaces::none)
            continue;
        covered.values[texel] = 1;
        const fresco::ModelMaterial& material = model.materials[model.material_of_face[face]];
        if (!cutout[face] || material.picture == fresco::ModelMaterial::no_picture)
            continue;
        const fresco::Raster8& picture = pictures[static_cast<std::size_t>(material.picture)];
        if (picture.channels != 4)
            continue;
        const std::array<double, 3> weights = texel_weights(atlas, faces, texel);
        double u = 0;
        double v = 0;
        for (std::size_t k = 0; k < 3; ++k)
        {
            u += weights[k] * model.mesh.texcoords[3 * std::size_t{face} + k].x;
            v += weights[k] * model.mesh.texcoords[3 * std::size_t{face} + k].y;
        }
        alpha.values[texel] = static_cast<float>(picture.at(wrapped(u, picture.width, material.wrap_u),
                                                            wrapped(1 - v, picture.height, material.wrap_v), 3)) /
                              255;
    }
    run.check_canceled();
    fresco::push_pull(alpha, covered);
    fresco::Raster8 result(size_px, size_px, 1);
    for (std::size_t texel = 0; texel < alpha.values.size(); ++texel)
        result.values[texel] = static_cast<std::uint8_t>(std::lround(std::clamp(alpha.values[texel], 0.0F, 1.0F) * 255));
    return result;
}

}  // namespace export_model
