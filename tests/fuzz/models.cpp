#include "parsers.h"

#include "plugins/scan/mesh/file_model.h"
#include "plugins/scan/mesh/mtl.h"

#include <fresco/error.h>
#include <fresco/mesh.h>

namespace fresco::fuzz
{

void read_gltf(Bytes bytes)
{
    // For files that name it as a buffer or as a picture.
    static const auto beside = file_with(std::as_bytes(std::span("\x89PNG\r\n\x1a\n, not looked at")), "beside.bin");
    const auto file = file_with(bytes, "model.gltf");
    for (const bool with_materials : {false, true})
    {
        const auto model = scan_mesh::read_gltf_model(file, with_materials);
        // A mesh of degenerate faces only has none.
        if (!model.mesh.triangles.empty())
            check_mesh(model.mesh, "the model");
        require(model.material_of_face.size() == model.mesh.triangles.size(), "a material per face");
        for (const std::uint32_t material : model.material_of_face)
            require(material < model.materials.size(), "materials that are there");
    }
}

namespace
{

void read_mtl(Bytes bytes)
{
    scan_mesh::parse_mtl(text_of(bytes), source);
}

const Registered registered{{"gltf", "plugins/shared/gltf/src/.*|plugins/scan/mesh/gltf_.*\\.cpp", read_gltf},
                            {"mtl", "plugins/scan/mesh/mtl\\.cpp", read_mtl}};

}  // namespace
}  // namespace fresco::fuzz
