#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/reader.h>
#include <fresco/relief.h>
#include <fresco/stage.h>
#include <fresco/texturing/exports.h>

#include "check_glb.h"
#include "glb.h"

#include <string>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
class ExportGltf final : public Stage
{
    ExportedMesh exported{this};
    Input<Relief> relief{this, "relief", optional, "Normals and roughness of the paint (texture.relief)"};
    Output<Files> files{this, "files", "One .glb file"};
    Option<OutputName> path{this, "path", OutputName{"room.glb"}, extensions({".glb"}), "Output path below --out"};
    Option<std::string> material{
        this, "material", "unlit", one_of({"unlit", "pbr"}),
        "unlit: as painted (KHR_materials_unlit); pbr: lit, rough, smooth normals; always pbr with a relief or without colors"};
    PictureOptions picture{this};
    Option<bool> quantize{
        this, "quantize", false,
        "16-bit positions and texcoords, 8-bit normals (KHR_mesh_quantization): 12 bytes per vertex instead of 20"};
    Option<std::string> compression{this, "compression", "none", one_of({"none", "meshopt"}),
                                    "meshopt: EXT_meshopt_compression, which not every viewer reads; triangles are reordered"};
    geometry::UprightOption up{this};

    GlbOptions glb_options(RunContext& run) const
    {
        // Without any color an unlit shape would be white all over, and unlit paint has no relief.
        const bool has_colors = exported.has_picture() || !exported.mesh().colors.empty();
        const bool is_lit = *material == "pbr" || relief.has_value() || !has_colors;
        return {.material = is_lit ? GltfMaterial::pbr : GltfMaterial::unlit,
                .turn = up.turn(exported.mesh(), {0, 1, 0}, run),
                .image_type = picture.extension() == ".jpg" ? "image/jpeg" : "image/png",
                .quantize = *quantize,
                .compress = *compression == "meshopt",
                .origin = run.origin()};
    }

    void check_inputs() const
    {
        exported.check();
        if (relief.has_value() && !exported.has_picture())
            throw Error("port 'relief' needs port 'textured_mesh': wire the mesh that texture.relief read");
    }

    void run(RunContext& run) override
    {
        check_inputs();
        GlbOptions options = glb_options(run);
        PictureOptions::Encoded image;
        if (exported.has_picture())
            image = picture.encoded(exported.textured(), picture.extension(), run);
        // The colors of a mesh with a picture would darken it.
        WeldedMesh welded = weld(exported.mesh(), !exported.has_picture());
        if (relief.has_value())
        {
            add_tangents(welded);
            options.relief = picture.encoded(*relief, exported.mesh(), NormalFrame::tangent, picture.extension(), run);
        }
        if (options.compress)
            order_for_compression(welded);
        run.check_canceled();
        const auto file = files.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        write_file(file, make_glb(welded, image.bytes, options));
        run.check_canceled();

        const std::string written = read_text_file(file, std::size_t{1} << 33U);
        const GlbModel model = read_glb(written, path->path);
        const GlbErrors errors = check_glb(model, welded, image.bytes, options);
        if (exported.has_picture())
        {
            const auto again = run.scratch_folder() / ("picture" + picture.extension());
            write_file(again, model.image);
            picture.check(again, image.picture(exported.textured()));
        }
        tell(run, written.size(), model, exported.has_picture() ? image.picture(exported.textured()).width : 0, errors);
        Files result;
        result.names = {path->path};
        files = std::move(result);
    }

    void tell(RunContext& run, std::size_t bytes, const GlbModel& model, int texture_px, const GlbErrors& errors) const
    {
        const std::string side = std::to_string(texture_px);
        const std::string shown = ", picture of " + side + " x " + side + " in " + file_size(model.image.size());
        run.message(valid_line(path->path, bytes,
                               grouped(model.indices.size() / 3) + " triangles" + (exported.has_picture() ? shown : "")));
        run.report("triangles", model.indices.size() / 3);
        run.report("vertices", model.positions.size());
        run.report("texture_px", texture_px);
        run.report("picture_bytes", model.image.size());
        run.report("bytes", bytes);
        run.report("position_error_m", errors.position_m);
        run.report("texcoord_error", errors.texcoord);
    }
};

/// What ExportGltf puts into `asset.extras`.
class GlbOrigin final : public FileOrigin
{
    std::vector<std::string> extensions() const override { return {".glb"}; }

    Value origin(const std::filesystem::path& file) const override
    {
        const Value document = parse_json(gltf::glb_json(file), file.string());
        const Value* asset = document.find("asset");
        const Value* extras = asset == nullptr ? nullptr : asset->find("extras");
        if (extras == nullptr || extras->find("stages") == nullptr || extras->find("versions") == nullptr)
            throw Error(file.string() + ": does not say how it was made: asset.extras has no stages and versions");
        return *extras;
    }
};
}  // namespace

FRESCO_STAGE("export.gltf", ExportGltf, "Writes a mesh with or without its picture as binary glTF 2.0 (GLB)")
FRESCO_COMPONENT("origin.gltf", GlbOrigin, FileOrigin, "Reads from a GLB how it was made")
