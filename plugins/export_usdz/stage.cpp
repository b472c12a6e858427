#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>

#include "usdz.h"

#include <algorithm>
#include <string>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
class ExportUsdz final : public Stage
{
    Input<TexturedMesh> textured_mesh{this, "textured_mesh", "The mesh with its picture, as texture.bake makes it"};
    Output<Files> files{this, "files", "One .usdz file"};
    Option<OutputName> path{this, "path", OutputName{"room.usdz"}, extensions({".usdz"}), "Output path below --out"};
    Option<std::string> material{this, "material", "unlit", one_of({"unlit", "pbr"}),
                                 "unlit: as painted (emitted); pbr: lit, rough, smooth normals"};
    PictureOptions picture{this};
    geometry::UprightOption up{this};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 0.1, .per = {{count::faces, 1.5e-6}, {count::texels, 2.4e-7}}},
                .memory_mb = {.fixed = 20, .per = {{count::faces, 2.5e-4}, {count::texels, 2.8e-5}}},
                .disk_mb = {.per = {{count::faces, 5e-5}, {count::texels, 2e-6}}}};
    }

    void run(RunContext& run) override
    {
        check_textured_mesh(*textured_mesh, "the mesh on port 'textured_mesh'");
        const WeldedMesh welded = weld(up.standing(textured_mesh->mesh, {0, 1, 0}, run));
        const PictureOptions::Encoded image = picture.encoded(*textured_mesh, picture.extension(), run);
        const std::string_view bytes(reinterpret_cast<const char*>(image.bytes.data()), image.bytes.size());
        const std::string name = "picture" + picture.extension();

        const auto file = files.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        ZipWriter zip(file);
        // The first file is the one that is opened.
        zip.begin("room.usda");
        write_usda(welded, {.picture = name, .lit = *material == "pbr"},
                   [&](std::string_view piece)
                   {
                       zip.write(piece);
                       run.check_canceled();
                   });
        zip.begin(name);
        zip.write(bytes);
        zip.finish();
        run.check_canceled();

        check(file, welded, image, run);
        const std::size_t size = std::filesystem::file_size(file);
        const std::string side = std::to_string(image.picture(*textured_mesh).width);
        run.message(valid_line(path->path, size,
                               grouped(welded.indices.size() / 3) + " triangles, picture of " + side + " x " + side + " in " +
                                   file_size(bytes.size())));
        run.report("triangles", welded.indices.size() / 3);
        run.report("vertices", welded.positions.size());
        run.report("texture_px", image.picture(*textured_mesh).width);
        run.report("picture_bytes", bytes.size());
        run.report("bytes", size);
        Files result;
        result.names = {path->path};
        files = std::move(result);
    }

    void check(const std::filesystem::path& file, const WeldedMesh& welded, const PictureOptions::Encoded& image,
               RunContext& run) const
    {
        const std::string written = read_text_file(file, std::size_t{1} << 33U);
        const std::vector<UsdzEntry> entries = read_usdz(written, path->path);
        const auto found = std::as_bytes(std::span(entries.at(1).data));
        if (entries.size() != 2 || !std::ranges::equal(found, image.bytes))
            throw Error(path->path + ": the written picture differs from what was to be written");
        check_usda(entries[0].data, welded);
        const auto again = run.scratch_folder() / ("picture" + picture.extension());
        write_file(again, found);
        picture.check(again, image.picture(*textured_mesh));
    }
};
}  // namespace

FRESCO_STAGE("export.usdz", ExportUsdz, "Writes a textured mesh as USDZ, which iPhones and iPads open from a link")
