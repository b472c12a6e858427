#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/images/recoloring.h>
#include <fresco/mesh.h>
#include <fresco/regions/regions.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;

namespace
{

/// Marks the faces with a corner of a marked one. A picture shows only some of the faces that are smaller than a pixel.
void add_ring(const Mesh& mesh, std::vector<std::uint8_t>& marked)
{
    std::vector<std::uint8_t> corners(mesh.positions.size(), 0);
    for (std::size_t f = 0; f < marked.size(); ++f)
        for (const std::uint32_t corner : mesh.triangles[f])
            corners[corner] |= marked[f];
    for (std::size_t f = 0; f < marked.size(); ++f)
        for (const std::uint32_t corner : mesh.triangles[f])
            marked[f] |= corners[corner];
}

class MeshInView final : public Stage
{
    static constexpr int height_px = 480;
    static constexpr int rings = 2;

    Input<Mesh> mesh{this, "mesh", "The mesh with its atlas"};
    Input<Texture> texture{this, "texture", "A texture of the same atlas, to paint over"};
    Input<Image> style{this, "style", optional,
                       "Recolors the texture with this picture's colors, nearly as texture.synthesize would recolor all of it"};
    Input<Regions> regions{this, "regions", optional, "Regions of the mesh"};
    Output<Mesh> part{this, "mesh", "The faces in view; they keep their texcoords"};
    Output<Texture> start{this, "texture", "The texture where these faces are"};
    Output<Regions> parts{this, "regions", optional, "The regions of these faces"};
    Option<std::vector<double>> position_m{this, "position_m", required, "Where the eye is: x, y, z in the mesh's frame"};
    Option<std::vector<double>> forward{this, "forward", required, "Where it looks: a direction"};
    Option<std::vector<double>> up{this, "up", required, "Which way is up in the view: a direction"};
    Option<double> field_deg{this, "field_deg", 60, range(1, 170), "Angle from the lower to the upper border of the view"};
    Option<double> aspect{this, "aspect", 1.5, range(0.1, 10), "Width of the view divided by its height"};

    static Vec3d vector_of(const Option<std::vector<double>>& option, const char* name)
    {
        if (option->size() != 3)
            throw Error(fmt::format("option \"{}\" has {} numbers; expected 3: x, y, z", name, option->size()));
        return {(*option)[0], (*option)[1], (*option)[2]};
    }

    Camera camera() const
    {
        const Vec3d ahead = normalized(vector_of(forward, "forward"));
        const Vec3d right = normalized(cross(ahead, vector_of(up, "up")));
        const Vec3d down = cross(ahead, right);
        if (!(length(down) > 0.5))
            throw Error("options \"forward\" and \"up\" must be two directions that differ");
        const int width = std::max(1, static_cast<int>(std::lround(height_px * *aspect)));
        const double focal = height_px / 2.0 / std::tan(*field_deg * std::numbers::pi / 360);
        return {{width, height_px, focal, focal, width / 2.0, height_px / 2.0},
                {Mat3{{right.x, down.x, ahead.x, right.y, down.y, ahead.y, right.z, down.z, ahead.z}},
                 vector_of(position_m, "position_m")}};
    }

    std::vector<std::uint8_t> faces_in_view(const Progress& progress) const
    {
        const Camera eye = camera();
        std::vector<FaceMap> maps{FaceMap(eye.intrinsics.width, eye.intrinsics.height)};
        rendering::RasterFinder(*mesh, true).find({&eye, 1}, progress, maps);
        std::vector<std::uint8_t> marked(mesh->triangles.size(), 0);
        for (const std::uint32_t face : maps.front().values)
            if (face != no_face)
                marked[face] = 1;
        if (std::ranges::count(marked, 1) == 0)
            throw Error("the view shows nothing of the mesh: turn toward it");
        for (int ring = 0; ring < rings; ++ring)
            add_ring(*mesh, marked);
        return marked;
    }

    /// The whole texture's colors decide, so that each view gets the same ones. texture.synthesize counts those that it fills in
    /// where nothing was seen, too.
    Recoloring recoloring(const RasterF& rgb, const Progress& progress) const
    {
        ColorMoments from;
        for (std::size_t texel = 0; texel < texture->seen.values.size(); ++texel)
            if (texture->seen.values[texel] != 0)
                from.add({double{rgb.values[3 * texel]}, double{rgb.values[3 * texel + 1]}, double{rgb.values[3 * texel + 2]}});
        if (style->pixels.channels == 3)
            return {from, style->pixels, {}};
        const auto picture = texturing::opaque_picture(style->pixels, "port 'style'", progress);
        return {from, picture.rgb, picture.opaque.values};
    }

    void run(RunContext& run) override
    {
        texturing::check_has_atlas(*mesh, "the mesh on port 'mesh'", "the atlas.* stage that the texture was made with");
        check_atlas(texture->atlas, *mesh, "the texture on port 'texture'");
        texturing::check_texture(*texture);
        if (style.has_value() && style->pixels.channels != 3 && style->pixels.channels != 4)
            throw Error(fmt::format("the style picture has {} channels; expected RGB or RGBA", style->pixels.channels));
        if (regions.has_value())
            check_regions(*regions, *mesh, "the regions on port 'regions'", "the mesh on port 'mesh'");
        const std::vector<std::uint8_t> in_view = faces_in_view(run);
        Mesh seen;
        seen.positions = mesh->positions;
        seen.texture_px = mesh->texture_px;
        seen.offset_m = mesh->offset_m;
        Regions named;
        for (std::size_t f = 0; f < in_view.size(); ++f)
        {
            if (in_view[f] == 0)
                continue;
            seen.triangles.push_back(mesh->triangles[f]);
            seen.texcoords.insert(seen.texcoords.end(), &mesh->texcoords[3 * f], &mesh->texcoords[3 * f] + 3);
            if (!mesh->charts.empty())
                seen.charts.push_back(mesh->charts[f]);
            if (regions.has_value())
                named.label_of_face.push_back(regions->label_of_face[f]);
        }
        run.report("faces", seen.triangles.size());
        start = start_of(seen, run);
        if (regions.has_value())
        {
            named.atlas = atlas_id(seen);
            named.names = regions->names;
            parts = std::move(named);
        }
        part = std::move(seen);
    }

    /// The other texels are black and unseen, which the store packs to nothing.
    Texture start_of(const Mesh& seen, const Progress& progress) const
    {
        const int size = texture->size_px();
        const RasterF rgb = texturing::collapse(*texture, progress);
        std::optional<Recoloring> recolored;
        if (style.has_value())
            recolored = recoloring(rgb, progress);
        const texturing::TexelFaces faces = texturing::find_texel_faces(seen, texturing::find_charts(seen), size, progress);
        Texture result;
        result.atlas = atlas_id(seen);
        result.seen = Raster8(size, size);
        RasterF& values = result.layers.emplace_back(size, size, 3);
        for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        {
            if (!faces.covered(texel) || texture->seen.values[texel] == 0)
                continue;
            const float* from = &rgb.values[3 * texel];
            const Vec3f color{from[0], from[1], from[2]};
            result.seen.values[texel] = 1;
            const auto [red, green, blue] = recolored ? (*recolored)(color) : color;
            std::ranges::copy(std::array{red, green, blue}, &values.values[3 * texel]);
        }
        return result;
    }
};

}  // namespace

FRESCO_STAGE("mesh.in_view", MeshInView, "Cuts out the faces that a camera sees, so that only these are painted")
