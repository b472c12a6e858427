#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>

#include "vertex_colors.h"

#include <string>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
class ExportPly final : public Stage
{
    ExportedMesh exported{this};
    Output<Files> files{this, "files", "A .ply file, and the picture of the same name beside it"};
    Option<OutputName> path{this, "path", OutputName{"room.ply"}, extensions({".ply"}),
                            "Output path below --out, without spaces"};
    Option<std::string> texcoords{
        this, "texcoords", "vertex", one_of({"vertex", "face", "none"}),
        "vertex: s and t, split along seams, as Blender reads them; face: six numbers per face, as MeshLab reads them"};
    Option<bool> colors{this, "colors", false, "Also write the picture's color around each vertex, as vertex colors"};
    geometry::UprightOption up{this};
    PictureOptions picture{this};

    PlyTexcoords place() const
    {
        if (exported.mesh().texcoords.empty())
            return PlyTexcoords::none;
        return *texcoords == "vertex" ? PlyTexcoords::vertex : *texcoords == "face" ? PlyTexcoords::face : PlyTexcoords::none;
    }

    std::vector<Rgb8> colors_to_write(RunContext& run) const
    {
        if (!exported.has_picture())
            return exported.mesh().colors;
        return *colors ? vertex_colors(exported.textured(), run) : std::vector<Rgb8>{};
    }

    void run(RunContext& run) override
    {
        exported.check();
        check_path_for_names(path->path);
        const auto folder = files.folder().path;
        std::filesystem::create_directories((folder / path->path).parent_path());
        Files result;
        result.names = {path->path};
        std::string picture_name;
        if (place() != PlyTexcoords::none && exported.has_picture())
        {
            result.names.push_back(picture.write(exported.textured(), folder, path->path, run));
            picture_name = std::filesystem::path(result.names.back()).filename().string();
        }
        const Mesh meant = arranged(up.standing(exported.mesh(), {0, 0, 1}, run), colors_to_write(run), place());
        run.check_canceled();
        const auto file = folder / path->path;
        write_file(file, textured_ply(meant, place(), picture_name));
        check_written_mesh(read_mesh(file), meant);

        run.message(valid_line(path->path, std::filesystem::file_size(file),
                               grouped(meant.triangles.size()) + " triangles, " + grouped(meant.positions.size()) + " vertices"));
        run.report("triangles", meant.triangles.size());
        run.report("vertices", meant.positions.size());
        run.report("bytes", static_cast<std::size_t>(std::filesystem::file_size(file)));
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("export.ply", ExportPly, "Writes a mesh as binary PLY, with its picture or with vertex colors")
