#pragma once

#include <fresco/artifact.h>
#include <fresco/mesh.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// What a picture shows outside of [0,1].
enum class Wrap : std::uint8_t
{
    repeat,
    mirror,
    clamp
};

/// What a face looks like: the product of the color, the picture and the vertex colors, in linear light.
struct ModelMaterial
{
    static constexpr int no_picture = -1;

    std::string name;
    Vec3f color{1, 1, 1};      ///< Linear light, 0 to 1.
    int picture = no_picture;  ///< Index into Model::pictures.
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    bool vertex_colors = false;  ///< The mesh's colors count.
};

/// A surface as another program textured it: several materials, each with its color and picture. Positions in the world, meters.
/// On disk: `mesh.ply`, `model.json`, `materials.npy` (uint32 F: the material of each face), and the pictures as PNG or JPEG.
struct Model : Artifact
{
    static constexpr std::string_view artifact_name = "model";
    static constexpr int artifact_version = 1;

    Mesh mesh;  ///< Its texcoords may lie outside of [0,1].
    std::vector<ModelMaterial> materials;
    std::vector<std::uint32_t> material_of_face;  ///< F; indices into materials.
    /// File names. The stage that makes a model writes each one into its output's folder().path.
    std::vector<std::string> pictures;
    std::filesystem::path loaded_from;  ///< Where load() found the pictures. Not saved.

    ~Model() override;
    Model() = default;
    Model(const Model&) = default;
    Model(Model&&) = default;
    Model& operator=(const Model&) = default;
    Model& operator=(Model&&) = default;

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Model> load(const ArtifactFolder& folder);
};

/// Throws Error naming `source` and the first offence: what check_mesh refuses, a face without a material, a material whose
/// picture is missing or whose color is not finite and from 0 to 1, a material with a picture on a mesh without texcoords, one
/// with vertex colors on a mesh without.
void check_model(const Model& model, std::string_view source);

}  // namespace fresco
