#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include "glb.h"

#include <algorithm>
#include <string>

using namespace fresco;

namespace
{
class ExportGltf final : public Stage
{
    Input<TexturedMesh> mesh{this, "mesh", "The mesh with its picture, as texture.bake makes it"};
    Output<Files> files{this, "files", "One .glb file"};
    Option<OutputName> path{this, "path", OutputName{"room.glb"}, "Where to write, below --out; ends in .glb"};
    Option<std::string> material{
        this, "material", "unlit", one_of({"unlit", "pbr"}),
        "unlit: shown as painted (KHR_materials_unlit); pbr: lit by the viewer, rough, with smooth normals"};
    Option<std::string> image_format{this, "image_format", "png", one_of({"png", "jpeg"}),
                                     "How the picture is stored in the file"};
    Option<int> jpeg_quality{this, "jpeg_quality", 92, range(1, 100), "For image_format: jpeg"};
    Option<int> max_texture_px{this, "max_texture_px", 0, range(0, 65536), "Shrink the picture to this side; 0 = as it is"};
    Option<std::string> up{this, "up", "keep", one_of({"keep", "z", "-y"}),
                           "The world's axis that points up: the node is turned so that it becomes glTF's +Y; keep: not turned"};
    Slot<ImageIo> images{this, "images", "image.opencv", "Encodes the picture"};

    Cost cost() const override
    {
        return {.seconds = "0.5 + faces * 1.2e-6",
                .memory_mb = "140 + faces * 0.0002",
                .disk_mb = "30 + faces * 3e-5",
                .frames = {},
                .faces = {}};
    }

    Raster8 picture() const
    {
        const Raster8& pixels = mesh->image.pixels;
        if (*max_texture_px == 0 || std::max(pixels.width, pixels.height) <= *max_texture_px)
            return pixels;
        return resized(pixels, std::min(pixels.width, *max_texture_px), std::min(pixels.height, *max_texture_px));
    }

    void run(RunContext& run) override
    {
        check_mesh(mesh->mesh, "the mesh on port 'mesh'");
        if (mesh->mesh.texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: export what texture.bake made");
        if (!path->path.ends_with(".glb"))
            throw Error("path \"" + path->path + "\" does not end in .glb");
        const bool jpeg = *image_format == "jpeg";
        const Raster8 pixels = picture();
        const auto encoded = jpeg ? images->encode_jpeg(pixels, *jpeg_quality) : images->encode_png(pixels);
        run.check_cancelled();
        const WeldedMesh welded = weld(mesh->mesh);
        run.check_cancelled();
        GlbOptions options;
        options.material = *material == "pbr" ? GltfMaterial::pbr : GltfMaterial::unlit;
        options.up = *up == "z" ? GltfUp::z : *up == "-y" ? GltfUp::minus_y : GltfUp::keep;
        options.image_type = jpeg ? "image/jpeg" : "image/png";
        const auto file = files.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        const auto glb = make_glb(welded, encoded, options);
        write_file(file, glb);

        run.report("triangles", welded.indices.size() / 3);
        run.report("vertices", welded.positions.size());
        run.report("texture_px", pixels.width);
        run.report("bytes", glb.size());
        Files result;
        result.names = {path->path};
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("export.gltf", ExportGltf, "Writes a textured mesh as binary glTF 2.0 (GLB)")
