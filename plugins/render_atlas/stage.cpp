#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/atlas_figures.h>
#include <fresco/image_io.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

using namespace fresco;

namespace
{

class RenderAtlas final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "A mesh with texture coordinates, as any atlas.* stage makes it"};
    Output<Files> picture{this, "picture", "One RGB PNG, with a color per chart"};
    Option<OutputName> path{this, "path", OutputName{"atlas.png"}, "Path of the picture, below --out"};
    Option<int> picture_px{this, "picture_px", 1024, range(16, 8192), "Side of the picture"};
    Option<int> size_px{this, "size_px", 0, range(0, 16384), "Texture size for texels_per_cm; 0: as the atlas says"};
    Slot<ImageIo> images{this, "Encodes the picture"};

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (mesh->texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texture coordinates: wire the atlas.* stage that makes them");
        const int size = painted_size_px(*size_px, mesh->texture_px, "the mesh on port 'mesh'", run);
        try
        {
            geometry::report_atlas(run, geometry::atlas_figures(*mesh, size));
        }
        catch (const std::invalid_argument&)
        {
            throw Error("the mesh on port 'mesh' has no area, on the surface or in its atlas: check how it was made");
        }
        run.check_canceled();
        const auto bytes = images->encode_png(geometry::atlas_picture(*mesh, *picture_px, &run));
        const auto file = picture.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        write_file(file, bytes);
        Files result;
        result.names.push_back(path->path);
        picture = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("render.atlas", RenderAtlas, "Picture and figures of a mesh's texture coordinates, chart by chart")
