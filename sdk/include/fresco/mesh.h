#pragma once

#include <fresco/artifact.h>
#include <fresco/cost.h>
#include <fresco/math.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

using Triangle = std::array<std::uint32_t, 3>;

/// An indexed triangle mesh, world frame, meters. Faces are counter-clockwise seen from outside.
/// On disk: `mesh.ply`, binary little-endian, with `list uchar float texcoord` and `int chart` per face where present, and
/// `comment texture_px N` where the texture's size is known.
struct Mesh : Artifact
{
    static constexpr std::string_view artifact_name = "mesh";
    static constexpr int artifact_version = 1;
    static constexpr std::string_view file_name = "mesh.ply";

    std::vector<Vec3f> positions;       ///< V
    std::vector<Rgb8> colors;           ///< V or empty; sRGB
    std::vector<Triangle> triangles;    ///< F; indices < V
    std::vector<Vec2f> texcoords;       ///< 3F, one per corner, or empty; uv in [0,1], origin at the lower left
    std::vector<std::uint32_t> charts;  ///< F or empty: the atlas chart of each face, counted from 0
    /// Texels per side of the texture that the texcoords are laid out for; 0: unknown. The one source of that size: uv maps pass
    /// it on, and what paints takes it.
    int texture_px = 0;

    ~Mesh() override;
    Mesh() = default;
    Mesh(const Mesh&) = default;
    Mesh(Mesh&&) = default;
    Mesh& operator=(const Mesh&) = default;
    Mesh& operator=(Mesh&&) = default;

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Mesh> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
};

/// Throws Error naming `source` and the first offence: no faces, an index out of range, a position that is not finite or more
/// than 1e7 m from the origin along an axis, faces of less than 1e-8 m² in all, arrays whose sizes do not match, a texcoord that
/// is not finite.
void check_mesh(const Mesh& mesh, std::string_view source);

/// Identifies an atlas: a hash of the triangles and texcoords, 32 hexadecimal digits. Textures and uv maps carry
/// it, so that a stage can refuse a texture that was made for another atlas.
std::string atlas_id(const Mesh& mesh);
/// Throws Error unless `id`, of what `source` names ("the texture on port 'start'"), is the mesh's atlas_id. An empty id is
/// unknown and passes.
void check_atlas(const std::string& id, const Mesh& mesh, std::string_view source);

/// F normals by the right-hand rule, unit length; zero for degenerate faces.
std::vector<Vec3f> face_normals(const Mesh& mesh);
/// V normals: area-weighted mean of the faces around, unit length; zero where there is none.
std::vector<Vec3f> vertex_normals(const Mesh& mesh);

/// What costs of stages count by.
namespace count
{
inline constexpr Counted faces{.name = "faces", .assumed = 1e6, .carried_by = "mesh"};
}  // namespace count

}  // namespace fresco
