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

/// An OBJ file and, behind a line "mtl", the file a.mtl beside it; pictures t.1001.png and t.1002.png, not looked at.
void read_obj_model(Bytes bytes)
{
    constexpr std::string_view border = "\nmtl\n";
    for (const char* picture : {"t.1001.png", "t.1002.png"})
        file_with({}, picture);
    const auto end = std::min(text_of(bytes).find(border), bytes.size());
    file_with(bytes.subspan(std::min(end + border.size(), bytes.size())), "a.mtl");
    const auto file = file_with(bytes.first(end), "model.obj");
    const auto model = scan_mesh::read_file_model(file, true);
    require(model.material_of_face.size() == model.mesh.triangles.size(), "a material per face");
    for (const std::uint32_t material : model.material_of_face)
        require(material < model.materials.size(), "materials that are there");
    for (const auto& material : model.materials)
        require(material.picture < static_cast<int>(model.pictures.size()), "pictures that are there");
    for (const auto& picture : model.pictures)
        require(std::filesystem::canonical(picture.file).parent_path() == std::filesystem::canonical(file).parent_path(),
                "pictures from the folder");
}

const Registered registered{
    {"gltf", "plugins/shared/gltf/src/.*|plugins/scan/mesh/gltf_.*\\.cpp", read_gltf},
    {"mtl", "plugins/scan/mesh/mtl\\.cpp", read_mtl},
    {"obj_model", "plugins/scan/mesh/(file_model|mtl)\\.cpp|plugins/shared/recordings/src/listed_files\\.cpp", read_obj_model}};

}  // namespace
}  // namespace fresco::fuzz
