#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>

#include "mesh_files.h"

#include <filesystem>
#include <string>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
class ExportMesh final : public Stage
{
    ExportedMesh exported{this};
    Output<Files> files{this, "files", "The file at path; for an OBJ its .mtl, and the picture of the same name beside either"};
    Option<OutputName> path{
        this, "path", OutputName{"room.obj"}, extensions({".obj", ".ply", ".png", ".jpg", ".jpeg", ".npy"}),
        "Output path below --out: a mesh (.obj, .ply; without spaces) or only its picture (.png, .jpg, .npy)"};
    Option<bool> colors{this, "colors", false, "PLY: the picture's colors at the vertices instead of the picture and texcoords"};
    geometry::UprightOption up{this};
    Option<std::string> coordinates{
        this, "coordinates", "local", one_of({"local", "original"}),
        "Of a scan far from 0, local: less the offset that its reader took off, as programs with floats want it; original: as "
        "the scan has them, unturned, in double"};
    PictureOptions picture{this};

    void run(RunContext& run) override
    {
        exported.check();
        if (is_original() && !up.names_no_axis())
            throw Error("coordinates: original leaves the mesh as the scan has it: remove option \"up\", or set up: keep");
        const std::string extension = std::filesystem::path(path->path).extension().string();
        Files result;
        result.names = {path->path};
        std::filesystem::create_directories((files.folder().path / path->path).parent_path());
        if (extension == ".obj")
            write_obj(result, run);
        else if (extension == ".ply")
            write_ply(result, run);
        else
        {
            if (!exported.has_picture())
                throw Error("path \"" + path->path +
                            "\" is a picture, which port 'mesh' lacks: wire 'textured_mesh', or write "
                            "an .obj or .ply");
            picture.write(exported.textured(), files.folder().path, path->path, run);
        }
        files = std::move(result);
    }

    bool is_original() const { return *coordinates == "original"; }

    Mesh placed(Vec3d target, RunContext& run) const
    {
        return is_original() ? exported.mesh() : up.standing(exported.mesh(), target, run);
    }

    /// Writes the picture beside the mesh. Returns its name in that folder.
    std::string write_picture(Files& result, RunContext& run)
    {
        result.names.push_back(std::filesystem::path(path->path).replace_extension(picture.extension()).generic_string());
        picture.write(exported.textured(), files.folder().path, result.names.back(), run);
        return std::filesystem::path(result.names.back()).filename().string();
    }

    void write_obj(Files& result, RunContext& run)
    {
        check_path_for_names(path->path);
        Mesh standing = placed({0, 1, 0}, run);
        std::string material_file;
        if (exported.has_picture())
        {
            standing.colors.clear();
            const std::string mtl = std::filesystem::path(path->path).replace_extension(".mtl").generic_string();
            result.names.push_back(mtl);
            write_file(files.folder().path / mtl, mtl_text("texture", write_picture(result, run)));
            material_file = std::filesystem::path(mtl).filename().string();
        }
        write_file(files.folder().path / path->path, obj_text(standing, material_file, "texture", is_original()));
        tell(standing, run);
    }

    void write_ply(Files& result, RunContext& run)
    {
        check_path_for_names(path->path);
        const bool has_picture = exported.has_picture() && !*colors;
        const std::string picture_name = has_picture ? write_picture(result, run) : "";
        Mesh standing = placed({0, 0, 1}, run);
        if (exported.has_picture())
            standing.colors.clear();
        if (exported.has_picture() && *colors)
        {
            standing.colors = vertex_colors(exported.textured(), run);
            standing.texcoords.clear();
        }
        const Mesh split = split_at_seams(standing);
        run.check_canceled();
        write_file(files.folder().path / path->path, textured_ply(split, picture_name, is_original()));
        run.report("vertices", split.positions.size());
        tell(split, run);
    }

    void tell(const Mesh& mesh, RunContext& run) const
    {
        const std::size_t bytes = std::filesystem::file_size(files.folder().path / path->path);
        run.message(path->path + ": " + file_size(bytes) + ", " + grouped(mesh.triangles.size()) + " triangles, " +
                    grouped(mesh.positions.size()) + " vertices");
        run.report("triangles", mesh.triangles.size());
        run.report("bytes", bytes);
        if (mesh.offset_m != Vec3d{} && !is_original())
            tell_offset(mesh.offset_m, run);
    }
};
}  // namespace

FRESCO_STAGE("export.mesh", ExportMesh, "Writes a mesh as OBJ or PLY, with its picture if it has one, or only the picture")
