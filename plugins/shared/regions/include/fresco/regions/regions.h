#pragma once

#include <fresco/artifact.h>
#include <fresco/mesh.h>
#include <fresco/run_context.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// Named parts of a mesh's surface: a label for each face. On disk: `regions.json` and `labels.npy` (uint16 F).
struct Regions : Artifact
{
    static constexpr std::string_view artifact_name = "regions";
    static constexpr int artifact_version = 1;

    std::string atlas;                         ///< The atlas_id of the mesh.
    std::vector<std::string> names;            ///< Each once, none empty.
    std::vector<std::uint16_t> label_of_face;  ///< F; indices into names.

    ~Regions() override;
    Regions() = default;
    Regions(const Regions&) = default;
    Regions(Regions&&) = default;
    Regions& operator=(const Regions&) = default;
    Regions& operator=(Regions&&) = default;

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Regions> load(const ArtifactFolder& folder);
};

/// Region of faces that no label, mask or plane names.
inline constexpr std::string_view other_region = "other";

/// Throws Error naming `source` ("the regions on port 'regions'") unless they are valid and of this mesh, which `mesh_source`
/// names.
void check_regions(const Regions& regions, const Mesh& mesh, std::string_view source, std::string_view mesh_source);

/// The regions that faces with these labels form: names that no face has are left out, and faces without a label
/// (label >= names.size()) are called other_region. Throws Error for more than 65,535 names.
Regions regions_from(const Mesh& mesh, const std::vector<std::string>& names, const std::vector<std::uint32_t>& label_of_face);

/// Says how much of the surface each region is, and reports it as `area_share`.
void report_regions(const Regions& regions, const Mesh& mesh, RunContext& run);

}  // namespace fresco
