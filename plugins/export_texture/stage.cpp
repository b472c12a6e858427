#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>

#include <fmt/format.h>
#include <string>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
class ExportTexture final : public Stage
{
    Input<TexturedMesh> mesh{this, "mesh", "The mesh with its picture, as texture.bake makes it"};
    Output<Files> files{this, "files", "The picture"};
    Option<OutputName> path{this, "path", OutputName{"room.png"}, extensions({".png", ".jpg", ".jpeg", ".npy"}),
                            "Output path below --out; ends in .png, .jpg, .jpeg or .npy"};
    PictureEncoding encoding{this};

    void run(RunContext& run) override
    {
        check_textured_mesh(*mesh, "the mesh on port 'mesh'");
        const auto file = files.folder().path / path->path;
        const auto image = encoding.encoded(*mesh, file.extension().string(), run);
        const Raster8& picture = image.picture(*mesh);
        std::filesystem::create_directories(file.parent_path());
        write_file(file, image.bytes);
        encoding.check(file, picture);

        run.message(valid_line(path->path, image.bytes.size(), fmt::format("{0} x {0} texels", picture.width)));
        run.report("texture_px", picture.width);
        run.report("bytes", image.bytes.size());
        Files result;
        result.names = {path->path};
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("export.texture", ExportTexture, "Writes only the picture of a textured mesh")
