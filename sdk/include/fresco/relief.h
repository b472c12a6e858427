#pragma once

#include <fresco/artifact.h>
#include <fresco/image.h>
#include <fresco/math.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace fresco
{

/// How the paint on a textured mesh catches the light. Normals are those of the world, not of a tangent space: they are the same
/// on both sides of a seam, and whoever writes tangents turns them into the frames that it writes. An artifact of its own, so
/// that only those who light the surface read it. On disk: `relief.json`, and as packed rasters `normals` (uint16 S x S x 3) and
/// `roughness` (uint8 S x S).
struct Relief : Artifact
{
    static constexpr std::string_view artifact_name = "relief";
    static constexpr int artifact_version = 2;

    std::string atlas;  ///< The mesh's atlas_id.
    Raster16 normals;   ///< S x S x 3, see set_normal; zeros away from charts.
    Raster8 roughness;  ///< S x S, 0 … 255: smooth … rough, as in glTF.

    int size_px() const { return normals.width; }
    /// At least one value of a normal is not 0.
    bool has_normal(std::size_t texel) const;
    /// About unit length; to 1/65535 per component.
    Vec3f normal(std::size_t texel) const;
    /// `normal`: unit length.
    void set_normal(std::size_t texel, Vec3f normal);

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Relief> load(const ArtifactFolder& folder);
};

}  // namespace fresco
