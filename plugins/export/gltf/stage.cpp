#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/numerics/numerics.h>
#include <fresco/reader.h>
#include <fresco/relief.h>
#include <fresco/rendering/simplified.h>
#include <fresco/stage.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/glb.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <optional>
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
    Option<double> error_share{this, "error_share", 0, range(0, 0.1),
                               "With a picture: leave out vertices that lie nearer than this share of the mesh's longest side to "
                               "the surface between others; 0: keep all"};
    PictureOptions picture{this};
    geometry::UprightOption up{this};

    GlbOptions glb_options(RunContext& run) const
    {
        // Without any color an unlit shape would be white all over, and unlit paint has no relief.
        const bool has_colors = exported.has_picture() || !exported.mesh().colors.empty();
        return {.lit = *material == "pbr" || relief.has_value() || !has_colors,
                .turn = up.turn(exported.mesh(), {0, 1, 0}, run),
                .image_type = picture.extension() == ".jpg" ? "image/jpeg" : "image/png",
                .origin = origin_of(exported.mesh(), run)};
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
        std::optional<TexturedMesh> simplified;
        if (*error_share > 0 && exported.has_picture())
        {
            numerics::Bounds<float> box;
            for (const Vec3f corner : exported.mesh().positions)
                box.add(corner);
            const Vec3f size = box.high - box.low;
            simplified = rendering::simplified(exported.textured(), *error_share * std::max({size.x, size.y, size.z}));
        }
        // The colors of a mesh with a picture would darken it.
        WeldedMesh welded = weld(simplified ? simplified->mesh : exported.mesh(), !exported.has_picture());
        if (relief.has_value())
        {
            add_tangents(welded);
            options.relief = picture.encoded(*relief, exported.mesh(), NormalFrame::tangent, picture.extension(), run);
        }
        run.check_canceled();
        const std::string glb = make_glb(welded, image.bytes, options);
        const auto file = files.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        write_file(file, glb);
        const int texture_px = exported.has_picture() ? image.picture(exported.textured()).width : 0;
        tell_export(run, path->path, glb.size(), welded.indices.size() / 3, texture_px, image.bytes.size());
        run.report("vertices", welded.positions.size());
        Files result;
        result.names = {path->path};
        files = std::move(result);
    }
};

/// Reads what ExportGltf puts into `asset.extras`.
class GlbOrigin final : public FileOrigin
{
    std::vector<std::string> extensions() const override { return {".glb"}; }

    Value origin(const std::filesystem::path& file) const override
    {
        const Value document = parse_json(glb_json(file), file.string());
        const Value* asset = document.find("asset");
        const Value* extras = asset == nullptr ? nullptr : asset->find("extras");
        if (extras == nullptr || extras->find("stages") == nullptr || extras->find("versions") == nullptr)
            throw Error(file.string() + ": does not say how it was made: asset.extras has no stages and versions");
        return *extras;
    }

    /// The JSON of a GLB; the bytes behind it are not read. Throws Error naming the file, MissingInput if it does not exist.
    static std::string glb_json(const std::filesystem::path& file)
    {
        constexpr std::size_t most_json_bytes = std::size_t{1} << 26U;
        std::error_code error;
        if (!std::filesystem::is_regular_file(file, error))
            throw MissingInput(file.string() + ": no such file");
        std::ifstream stream(file, std::ios::binary);
        std::array<std::uint32_t, 5> header{};  // "glTF", version, length; length and type of the first chunk
        stream.read(reinterpret_cast<char*>(header.data()), sizeof header);
        if (!stream || header[0] != 0x46546C67 || header[1] != 2 || header[4] != 0x4E4F534A)
            throw Error(file.string() + ": is not a binary glTF 2.0 file");
        if (header[3] > most_json_bytes)
            throw Error(file.string() + ": its JSON chunk claims more than 64 MiB");
        std::string json(header[3], '\0');
        if (!stream.read(json.data(), static_cast<std::streamsize>(json.size())))
            throw Error(file.string() + ": ends within its JSON chunk");
        return json;
    }
};
}  // namespace

FRESCO_STAGE("export.gltf", ExportGltf, "Writes a mesh with or without its picture as binary glTF 2.0 (GLB)")
FRESCO_LIBRARY("meshoptimizer", rendering::meshoptimizer_version())
FRESCO_COMPONENT("origin.gltf", GlbOrigin, FileOrigin, "Reads from a GLB how it was made")
