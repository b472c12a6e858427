#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/relief.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>
#include <fresco/zip.h>

#include "usdz.h"

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
/// Less than the 4 GiB of a zip archive by some room for its headers.
constexpr std::uint64_t most_bytes = 4'294'000'000;

class ExportUsdz final : public Stage
{
    Input<TexturedMesh> textured_mesh{this, "textured_mesh", "The mesh with its picture, as texture.bake makes it"};
    Input<Relief> relief{this, "relief", optional, "Normals and roughness of the paint (texture.relief)"};
    Output<Files> files{this, "files", "One .usdz file"};
    Option<OutputName> path{this, "path", OutputName{"room.usdz"}, extensions({".usdz"}), "Output path below --out"};
    Option<std::string> material{this, "material", "unlit", one_of({"unlit", "pbr"}),
                                 "unlit: as painted (emitted); pbr: lit, rough, smooth normals; always pbr with a relief"};
    PictureOptions picture{this};
    geometry::UprightOption up{this};

    void run(RunContext& run) override
    {
        check_textured_mesh(*textured_mesh, "the mesh on port 'textured_mesh'");
        tell_offset(textured_mesh->mesh.offset_m, run);
        const WeldedMesh welded = weld(up.standing(textured_mesh->mesh, {0, 1, 0}, run));
        const PictureOptions::Encoded image = picture.encoded(*textured_mesh, picture.extension(), run);
        const std::string extension = picture.extension();
        PictureOptions::EncodedRelief maps;
        if (relief.has_value())
            maps = picture.encoded(*relief, textured_mesh->mesh, NormalFrame::tangent, extension, run);
        std::vector<std::pair<std::string, std::span<const std::byte>>> pictures{{"picture" + extension, image.bytes}};
        if (relief.has_value())
        {
            pictures.emplace_back("normals" + extension, maps.normals);
            pictures.emplace_back("roughness" + extension, maps.roughness);
        }

        const auto file = files.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        ZipWriter zip(file);
        std::uint64_t written = 0;
        const auto write = [&](std::string_view piece)
        {
            written += piece.size();
            if (written > most_bytes)
                throw Error(file.string() + ": a USDZ file holds at most 4 GiB: decimate the mesh or set max_texture_px");
            zip.write(piece);
        };
        // The first file is the one that is opened.
        zip.begin("room.usda");
        write_usda(welded,
                   {.picture = pictures[0].first,
                    .lit = *material == "pbr" || relief.has_value(),
                    .normals = relief.has_value() ? pictures[1].first : "",
                    .roughness = relief.has_value() ? pictures[2].first : ""},
                   [&](std::string_view piece)
                   {
                       write(piece);
                       run.check_canceled();
                   });
        for (const auto& [name, bytes] : pictures)
        {
            zip.begin(name);
            write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        }
        zip.finish();
        run.check_canceled();

        tell_export(run, path->path, std::filesystem::file_size(file), welded.indices.size() / 3,
                    image.picture(*textured_mesh).width, image.bytes.size());
        run.report("vertices", welded.positions.size());
        Files result;
        result.names = {path->path};
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("export.usdz", ExportUsdz, "Writes a textured mesh as USDZ, which iPhones and iPads open from a link")
