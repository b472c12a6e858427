#include "painted_model.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/recordings/layout.h>
#include <fresco/stage.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/glb.h>
#include <fresco/wording.h>

#include <fmt/format.h>

#include <string>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

enum class Uvs : std::uint8_t
{
    automatic,
    keep,
    second,
    fresh
};

class ExportModel final : public Stage
{
    Input<TexturedMesh> textured{this, "textured_mesh", "The painted atlas of the model (atlas.model)"};
    Input<Model> model{this, "model", "The model as scan.mesh read it"};
    Output<Files> files{this, "files", "The painted model; beside an OBJ its .mtl, beside an OBJ or PLY the picture"};
    Option<InputFile> file{this, "file", required, "The model's file"};
    Option<OutputName> path{this, "path", OutputName{"room"},
                            "Output path below --out without extension: .glb for GLB and glTF, else as the model's file"};
    Choice<Uvs> uvs{this,
                    "uvs",
                    Uvs::automatic,
                    {{"auto", Uvs::automatic}, {"keep", Uvs::keep}, {"second", Uvs::second}, {"new", Uvs::fresh}},
                    "As atlas.model has it; new: a GLB of the atlas instead of the model's file"};
    PictureOptions picture{this};
    geometry::UprightOption up{this};

    void run(RunContext& run) override
    {
        check_textured_mesh(*textured, "the mesh on port 'textured_mesh'");
        check_model(*model, "the model on port 'model'");
        const export_model::PaintedFiles painted = is_fresh(run) ? fresh_model(run) : painted_model(run);
        for (const auto& each : painted.files_read)
            run.reads_file(each);
        for (const auto& pattern : painted.looked_for)
            recordings::looks_for(pattern, run);
        Files result;
        const auto folder = std::filesystem::path(path->path).parent_path();
        std::filesystem::create_directories(files.folder().path / folder);
        for (const auto& [name, contents] : painted.files)
        {
            result.names.push_back((folder / name).generic_string());
            write_file(files.folder().path / result.names.back(), contents);
        }
        run.report("vertices_added", painted.vertices_added);
        run.report("polygons_split", painted.polygons_split);
        for (const std::string& message : painted.messages)
            run.message(message);
        run.message(fmt::format("{}: {}, {} triangles", result.names[0], file_size(painted.files[0].second.size()),
                                grouped(textured->mesh.triangles.size())));
        files = std::move(result);
    }

    bool is_fresh(RunContext& run) const
    {
        const std::string extension = lower_extension(file->path);
        const bool is_known = extension == ".ply" || extension == ".obj" || extension == ".glb" || extension == ".gltf";
        if (!is_known && *uvs != Uvs::fresh)
            run.message(file->path.filename().string() +
                        " is of a format that is only read: the painted model is a GLB of its own");
        return !is_known || *uvs == Uvs::fresh;
    }

    std::string name() const { return std::filesystem::path(path->path).filename().string(); }

    bool keeps_uvs() const
    {
        const bool is_same = textured->mesh.texcoords == model->mesh.texcoords;
        if (*uvs == Uvs::keep && !is_same)
            throw Error(
                "the atlas on port 'textured_mesh' does not have the model's own texture coordinates: wire atlas.model with "
                "uvs: keep");
        return is_same && *uvs != Uvs::second;
    }

    export_model::PaintedFiles painted_model(RunContext& run)
    {
        if (model->mesh.triangles.size() != textured->mesh.triangles.size())
            throw Error(fmt::format(
                "the model on port 'model' has {} triangles, the painted mesh has {}: wire an atlas of the model as it "
                "is, without mesh.decimate, or set uvs: new",
                model->mesh.triangles.size(), textured->mesh.triangles.size()));
        const export_model::Painting painting{.atlas = textured->mesh,
                                              .keeps_uvs = keeps_uvs(),
                                              .picture = [&](const std::vector<bool>& cutout) { return encoded(cutout, run); },
                                              .name = name(),
                                              .origin = run.origin()};
        run.report("uvs", painting.keeps_uvs ? "keep" : "second");
        const std::string extension = lower_extension(file->path);
        if (extension == ".obj")
            return painted_obj(file->path, painting);
        return extension == ".ply" ? painted_ply(file->path, painting) : painted_gltf(file->path, painting);
    }

    /// A picture with the opacity of the model's own is a PNG.
    export_model::Picture encoded(const std::vector<bool>& cutout, RunContext& run)
    {
        const auto opaque = picture.encoded(*textured, picture.extension(), run);
        if (cutout.empty())
            return {opaque.bytes, picture.extension()};
        std::vector<Raster8> own(model->pictures.size());
        for (std::size_t face = 0; face < cutout.size(); ++face)
        {
            const int number = model->materials[model->material_of_face[face]].picture;
            if (cutout[face] && number != ModelMaterial::no_picture && own[static_cast<std::size_t>(number)].empty())
                own[static_cast<std::size_t>(number)] =
                    read_picture(picture.images(), model->loaded_from / model->pictures[static_cast<std::size_t>(number)]);
        }
        const Raster8& rgb = opaque.picture(*textured);
        const Raster8 alpha = export_model::cutout_alpha(*model, own, textured->mesh, cutout, rgb.width, run);
        Raster8 rgba(rgb.width, rgb.height, 4);
        for (std::size_t texel = 0; texel < alpha.values.size(); ++texel)
        {
            std::copy_n(&rgb.values[3 * texel], 3, &rgba.values[4 * texel]);
            rgba.values[4 * texel + 3] = alpha.values[texel];
        }
        return {picture.images().encode_png(rgba), ".png"};
    }

    export_model::PaintedFiles fresh_model(RunContext& run)
    {
        const auto image = picture.encoded(*textured, picture.extension(), run);
        const GlbOptions options{.lit = false,
                                 .turn = up.turn(textured->mesh, {0, 1, 0}, run),
                                 .image_type = picture.extension() == ".jpg" ? "image/jpeg" : "image/png",
                                 .origin = origin_of(textured->mesh, run)};
        run.report("uvs", "new");
        export_model::PaintedFiles result;
        result.files.emplace_back(name() + ".glb", make_glb(weld(textured->mesh), image.bytes, options));
        return result;
    }
};

}  // namespace

FRESCO_STAGE("export.model", ExportModel, "Writes a model's own file with the painting as its picture, all else kept")
