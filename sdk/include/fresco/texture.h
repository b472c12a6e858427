#pragma once

#include <fresco/artifact.h>
#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/mesh.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// A texture before baking. Layers are square, 3 channels, row 0 at the top (v = 1); the value at uv is the sum over
/// layers of a bilinear lookup with texel centers at +0.5, clamped at the borders.
/// On disk: `texture.json`, and as packed rasters (sdk/docs/packed_rasters.md) `layer_<i>` (float32 S_i x S_i x 3) and `seen`
/// (uint8 S x S).
struct Texture : Artifact
{
    static constexpr std::string_view artifact_name = "texture";
    static constexpr int artifact_version = 3;

    /// Meaning of the values: "display" = RGB in [0,1]; "network" = BGR in 0..255 minus (103.939, 116.779, 123.68).
    std::string values = "display";
    std::string atlas;            ///< The atlas_id of the mesh it was made for; empty: unknown.
    std::vector<RasterF> layers;  ///< Finest first; layer i has size S / 2^i.
    Raster8 seen;                 ///< S x S: 1 where the values are known: some frame saw the texel, or it was painted.

    int size_px() const { return layers.empty() ? 0 : layers.front().width; }
    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Texture> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
    /// With NPY files in place of packed rasters.
    void write_exchange(const Exchange& to) const override;
};

/// A mesh with texcoords and the picture they point into (RGB, square). On disk: `mesh.ply`, a link where the mesh is another
/// artifact's (Mesh::saved_in), and `image.packed`.
struct TexturedMesh : Artifact
{
    static constexpr std::string_view artifact_name = "textured_mesh";
    static constexpr int artifact_version = 3;

    Mesh mesh;
    Image image;

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<TexturedMesh> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
    void write_exchange(const Exchange& to) const override;
    static std::shared_ptr<TexturedMesh> from_exchange(const Exchange& from);
};

/// Texels per side to paint at: `size_px`, an option whose 0 stands for `laid_out_px`, the texture_px of what `source` names
/// ("the mesh on port 'mesh'"). Warns where the two differ. Throws Error where neither is known, or outside 16 … 16384.
int painted_size_px(int size_px, int laid_out_px, std::string_view source, RunContext& run);

/// Bilinear value at (u, v) of a raster whose row 0 is v = 1: texel centers at +0.5, clamped at the borders.
void sample_bilinear(const RasterF& texture, float u, float v, float* out);

/// Source position in a picture of each texel of a painted texture, so that a finer texture or another channel can be copied
/// without a new search. On disk: `source_map.json`, and as packed rasters `places` (uint16 S x S x 4) and `shifts` (uint8 S x S
/// x 3).
struct SourceMap : Artifact
{
    static constexpr std::string_view artifact_name = "source_map";
    static constexpr int artifact_version = 4;

    /// A texel's place in the picture.
    struct Place
    {
        Vec2f at;  ///< Pixels of the picture, (0, 0) at its upper left corner, pixel centers at +0.5.
        float angle =
            0;  ///< Radians: a texel to the right in the texture is scale pixels_per_texel (cos, sin) in the picture, y down.
        float scale = 1;  ///< How much smaller the picture is here than where it has pixels_per_texel.
        Vec3f shift{};    ///< Added to the picture's color here; RGB, each within about 0.5.
    };

    std::string atlas;           ///< The mesh's atlas_id; empty: unknown.
    int picture_width = 0;       ///< Width of the whole picture …
    int picture_height = 0;      ///< … that places are in.
    float pixels_per_texel = 1;  ///< The picture's pixels along a texel's side, at scale 1.
    Raster16 places;             ///< S x S x 4: column and row in 1/65534 of the picture's width and height, angle in
                                 ///< 1/65534 turn, scale in 1/256; all 0xffff where nothing was copied.
    Raster8 shifts;              ///< S x S x 3: 128 + shift in 1/255.

    int size_px() const { return places.width; }
    /// Empty for a texel that was not copied from the picture.
    std::optional<Place> place(int x, int y) const;
    /// Begins a map of `size_px` texels a side, none of them copied.
    void clear(int size_px);
    /// Rounds to what the map can hold; places outside of the picture are clamped to it.
    void set_place(int x, int y, const Place& place);

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<SourceMap> load(const ArtifactFolder& folder);
};

}  // namespace fresco
