#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>

#include "obj_text.h"

#include <filesystem>
#include <string>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
class ExportObj final : public Stage
{
    ExportedMesh exported{this};
    Output<Files> files{this, "files", "An .obj file, and a .mtl and the picture of the same name beside it"};
    Option<OutputName> path{this, "path", OutputName{"room.obj"}, extensions({".obj"}),
                            "Output path below --out, without spaces"};
    geometry::UprightOption up{this};
    PictureOptions picture{this};

    void run(RunContext& run) override
    {
        exported.check();
        check_path_for_names(path->path);
        const auto folder = files.folder().path;
        const auto file = folder / path->path;
        std::filesystem::create_directories(file.parent_path());
        const auto name_of = [](const std::string& name) { return std::filesystem::path(name).filename().string(); };

        Mesh meant = up.standing(exported.mesh(), {0, 1, 0}, run);
        Files result;
        result.names = {path->path};
        std::string mtl;
        if (exported.has_picture())
        {
            meant.colors.clear();
            const std::string image = picture.write(exported.textured(), folder, path->path, run);
            mtl = std::filesystem::path(path->path).replace_extension(".mtl").generic_string();
            write_file(folder / mtl, mtl_text("texture", name_of(image)));
            result.names.insert(result.names.end(), {mtl, image});
        }
        write_file(file, obj_text(meant, name_of(mtl), "texture"));
        run.check_canceled();
        check_written_mesh(read_mesh(file), meant);

        const std::size_t bytes = std::filesystem::file_size(file);
        run.message(valid_line(path->path, bytes, grouped(meant.triangles.size()) + " triangles"));
        run.report("triangles", meant.triangles.size());
        run.report("bytes", bytes);
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("export.obj", ExportObj, "Writes a mesh as Wavefront OBJ, with MTL and picture if it has one")
