#include <fresco/mesh.h>
#include <fresco/reader.h>
#include <fresco/stage.h>

namespace
{

class ReadMesh final : public fresco::FileReader
{
    std::string artifact() const override { return std::string(fresco::Mesh::artifact_name); }
    std::vector<fresco::FileFormat> formats() const override { return {fresco::ply_format(), fresco::obj_format()}; }

    std::shared_ptr<const fresco::Artifact> read(const std::filesystem::path& file) override
    {
        auto mesh = std::make_shared<fresco::Mesh>(fresco::read_mesh(file));
        check_mesh(*mesh, file.string());
        return mesh;
    }
};

}  // namespace

FRESCO_COMPONENT("read.mesh", ReadMesh, fresco::FileReader, "Triangle meshes from PLY and OBJ files")
