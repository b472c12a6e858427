#include "painting.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/splats/painted_splats.h>
#include <fresco/stage.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/texel_faces.h>

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>

using namespace fresco;
using splats::SplatFormat;

namespace
{

class ExportSplats final : public Stage
{
    Input<TexturedMesh> textured{this, "textured_mesh", "The painted surface of the splat (scan.splats)"};
    Output<Files> files{this, "files", "The painted splat"};
    Option<InputPath> file{this, "file", required, "The splat that scan.splats read"};
    Option<OutputName> path{this, "path", OutputName{"painted"}, "Output path below --out without extension"};
    Option<double> unit_m{this, "unit_m", 1.0, range(1e-6, 1e6), "Meters per unit of the splat, as for scan.splats"};
    Choice<std::optional<SplatFormat>> format{
        this,
        "format",
        std::nullopt,
        {{"input", std::nullopt}, {"ply", SplatFormat::ply}, {"splat", SplatFormat::splat}, {"spz", SplatFormat::spz}},
        "input: the splat's own; ply for compressed PLY, SOG and GLB; spz is in meters"};
    Choice<bool> shine{this,
                       "shine",
                       false,
                       {{"drop", false}, {"keep", true}},
                       "Harmonics above degree 0, by which colors change with the view; keep: in the splat's own format"};
    Option<bool> densify{this, "densify", true, "Split Gaussians that are larger than a quarter of a stroke"};
    Option<double> stroke_cm{this, "stroke_cm", 0, range(0, 1000),
                             "Width of the strokes of the painting; 0: as texture.synthesize has it"};

    void run(RunContext& run) override
    {
        texturing::check_textured_mesh(*textured, "the mesh on port 'textured_mesh'");
        splats::SplatFile splat = splats::read_splats(file->path);
        for (const auto& each : splat.files)
            run.reads_file(each);
        const auto to = (*format).value_or(splats::is_written(splat.format) ? splat.format : SplatFormat::ply);
        if (*shine && to != splat.format)
            throw Error(fmt::format("shine: keep works only in the splat's own format, but {} becomes {}: set shine: drop",
                                    splats::name_of(splat.format), splats::name_of(to)));
        const Mesh& mesh = textured->mesh;
        const double stroke_m =
            *stroke_cm > 0 ? *stroke_cm / 100
                           : texturing::usual_stroke_m(mesh, texturing::mean_texel_m(mesh, textured->image.pixels.width));
        // SPZ is in meters.
        const bool becomes_metric = to == SplatFormat::spz && to != splat.format;
        for (std::size_t i = 0; becomes_metric && i < splat.splats.size(); ++i)
        {
            splat.splats.centers[i] = vec_cast<float>(vec_cast<double>(splat.splats.centers[i]) * *unit_m);
            splat.splats.scales[i] = vec_cast<float>(vec_cast<double>(splat.splats.scales[i]) * *unit_m);
        }
        auto painting = export_splats::paint(
            splat.splats, *textured, {.unit_m = becomes_metric ? 1 : *unit_m, .stroke_m = stroke_m, .densify = *densify}, run);
        if (painting.unpainted == splat.splats.size())
            throw Error("no Gaussian reaches the mesh: it was made from another splat, or with another unit_m");

        if (2 * painting.unpainted > splat.splats.size())
            run.warning(
                fmt::format("{} of {} Gaussians do not reach the mesh and keep their color: does unit_m agree with that of "
                            "scan.splats?",
                            painting.unpainted, splat.splats.size()));
        if (splats::is_metric(to) != splats::is_metric(splat.format))
            export_splats::turn_over(splat.splats, painting.splats);
        const std::string extension = to == SplatFormat::ply ? ".ply" : to == SplatFormat::splat ? ".splat" : ".spz";
        const auto bytes = splats::painted_bytes(file->path, splat, painting.splats, to, *shine);
        Files result;
        result.names = {path->path + extension};
        std::filesystem::create_directories((files.folder().path / result.names[0]).parent_path());
        write_file(files.folder().path / result.names[0], bytes);
        const std::size_t count = painting.splats.parts.size();
        run.message(fmt::format("{}: {}, {} Gaussians; {} of {} split, {} off the surface keep their color", result.names[0],
                                texturing::file_size(bytes.size()), texturing::grouped(count), texturing::grouped(painting.split),
                                texturing::grouped(splat.splats.size()), texturing::grouped(painting.unpainted)));
        if (!*format && to != splat.format)
            run.message(fmt::format("{} is written as plain PLY, which the same programs open", splats::name_of(splat.format)));
        run.report("gaussians", count);
        run.report("split", painting.split);
        run.report("unpainted", painting.unpainted);
        run.report("stroke_cm", 100 * stroke_m);
        run.report("bytes", bytes.size());
        files = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("export.splats", ExportSplats, "Writes a Gaussian splat with the colors of its painted surface")
