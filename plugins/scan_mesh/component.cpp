#include "file_model.h"
#include "joined_vertices.h"

#include <fresco/reader.h>
#include <fresco/stage.h>

namespace
{

/// Not `.gltf`, whose buffers are in files of their own: a port knows the one file that it names.
class ReadGlb final : public fresco::FileReader
{
    std::string artifact() const override { return std::string(fresco::Mesh::artifact_name); }
    std::vector<std::string> extensions() const override { return {".glb"}; }

    std::shared_ptr<const fresco::Artifact> read(const std::filesystem::path& file) override
    {
        auto surface = std::move(scan_mesh::read_file_model(file, false).mesh);
        scan_mesh::join_vertices(surface);
        return std::make_shared<fresco::Mesh>(std::move(surface));
    }
};

}  // namespace

FRESCO_COMPONENT("read.glb", ReadGlb, fresco::FileReader, "The shape of GLB files, in the file's axes and meters")
