#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include "obj_text.h"

#include <filesystem>
#include <string>

using namespace fresco;

namespace
{
class ExportObj final : public Stage
{
    Input<TexturedMesh> mesh{this, "mesh", "The mesh with its picture, as texture.bake makes it"};
    Output<Files> files{this, "files", "An .obj file, and a .mtl and a .png of the same name beside it"};
    Option<OutputName> path{this, "path", OutputName{"room.obj"}, "Where to write, below --out; ends in .obj, without spaces"};
    Slot<ImageIo> images{this, "images", "image.opencv", "Encodes the picture"};

    Cost cost() const override
    {
        return {.seconds = "0.5 + faces * 2e-6",
                .memory_mb = "140 + faces * 0.0002",
                .disk_mb = "30 + faces * 7e-5",
                .frames = {},
                .faces = {}};
    }

    /// The path with another extension, as generic text.
    std::string sibling(const char* extension) const
    {
        return std::filesystem::path(path->path).replace_extension(extension).generic_string();
    }

    void run(RunContext& run) override
    {
        check_mesh(mesh->mesh, "the mesh on port 'mesh'");
        if (mesh->mesh.texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: export what texture.bake made");
        if (!path->path.ends_with(".obj") || path->path.find_first_of(" \t\r\n") != std::string::npos)
            throw Error("path \"" + path->path + "\" must end in .obj and hold no spaces, which OBJ readers split names at");
        const auto folder = files.folder().path;
        const std::string mtl = sibling(".mtl");
        const std::string png = sibling(".png");
        std::filesystem::create_directories((folder / path->path).parent_path());
        const auto name_of = [](const std::string& file) { return std::filesystem::path(file).filename().string(); };

        write_file(folder / png, images->encode_png(mesh->image.pixels));
        run.check_cancelled();
        write_file(folder / mtl, mtl_text("texture", name_of(png)));
        write_file(folder / path->path, obj_text(mesh->mesh, name_of(mtl), "texture"));
        run.report("triangles", mesh->mesh.triangles.size());
        Files result;
        result.names = {path->path, mtl, png};
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("export.obj", ExportObj, "Writes a textured mesh as Wavefront OBJ with MTL and PNG")
