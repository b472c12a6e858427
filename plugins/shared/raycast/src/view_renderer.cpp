#include <fresco/error.h>
#include <fresco/parallel.h>
#include <fresco/raycast/surface.h>
#include <fresco/raycast/view_renderer.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace fresco::raycast
{
namespace
{

std::uint8_t rounded(double v)
{
    return static_cast<std::uint8_t>(std::clamp(v + 0.5, 0.0, 255.0));
}
}  // namespace

void check_showable(const TexturedMesh& mesh, const Frames& frames)
{
    check_mesh(mesh.mesh, "the mesh on port 'mesh'");
    if (mesh.mesh.texcoords.empty())
        throw Error("the mesh on port 'mesh' has no texcoords: wire what texture.bake made");
    if (frames.frames.empty())
        throw Error("port 'frames' has no frames: check the scan's path and the stages that drop frames");
    for (const Frame& frame : frames.frames)
        check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
}

Lights lights_of(std::string_view shading)
{
    if (shading == "scannet")
        return {0.4, 1, normalized(Vec3d{1, 1, 1})};
    if (shading == "matterport3d")
        return {0.9, 0.6, normalized(Vec3d{1, 0, 1})};
    return {};
}

Lighting::Lighting(const Mesh& mesh, const Lights& lights) : mesh_(mesh), lights_(lights)
{
    if (lights.diffuse > 0)
        normals_ = vertex_normals(mesh);
}

double Lighting::at(const Hit& hit) const
{
    if (normals_.empty())
        return lights_.ambient;
    return lights_.ambient + lights_.diffuse * std::max(0.0, dot(normal(mesh_, normals_, hit), lights_.toward));
}

ViewRenderer::ViewRenderer(const TexturedMesh& mesh, const RenderOptions& options)
    : options_(options), scene_(mesh.mesh), texture_(mesh.image.pixels, options.mip_maps), lighting_(mesh.mesh, options.lights)
{
}

double ViewRenderer::level_of_detail(const Camera& dense, int x, int y, const Hit& hit, Vec2d uv) const
{
    if (!options_.mip_maps)
        return 0;
    // Between this ray and its neighbors, all on the triangle's plane.
    const double texels =
        texels_per_pixel(scene_.mesh(), hit.triangle, uv, dense, x + 0.5, y + 0.5, texture_.width(), texture_.height());
    return texels > 1 ? std::log2(texels) : 0;
}

void ViewRenderer::render_rows(const Camera& camera, const Camera& dense, int first_row, int end_row, Raster8& image) const
{
    const int side = options_.samples_per_side;
    const int width = dense.intrinsics.width;
    std::vector<Hit> hits(static_cast<std::size_t>((end_row - first_row) * side) * static_cast<std::size_t>(width));
    scene_.cast_rows(dense, first_row * side, end_row * side, hits);
    const auto draw_pixel = [&](int x, int y)
    {
        Vec3d sum;
        int found = 0;
        for (int dense_y = y * side; dense_y < (y + 1) * side; ++dense_y)
            for (int dense_x = x * side; dense_x < (x + 1) * side; ++dense_x)
            {
                const Hit& hit = hits[static_cast<std::size_t>(dense_y - first_row * side) * static_cast<std::size_t>(width) +
                                      static_cast<std::size_t>(dense_x)];
                if (sight(hit) != Sight::surface)
                    continue;
                const Vec2d uv = texcoord(scene_.mesh(), hit);
                const Vec3d color = texture_.sample(uv, level_of_detail(dense, dense_x, dense_y, hit, uv)) * lighting_.at(hit);
                sum += Vec3d{std::min(color.x, 255.0), std::min(color.y, 255.0), std::min(color.z, 255.0)};
                ++found;
            }
        if (found == 0)
            return;
        const Vec3d mean = sum * (1.0 / found);
        std::uint8_t* rgba = &image.at(x, y);
        rgba[0] = rounded(mean.x);
        rgba[1] = rounded(mean.y);
        rgba[2] = rounded(mean.z);
        rgba[3] = rounded(255.0 * found / (side * side));
    };
    for (int y = first_row; y < end_row; ++y)
        for (int x = 0; x < camera.intrinsics.width; ++x)
            draw_pixel(x, y);
}

Raster8 ViewRenderer::render(const Camera& camera, const Progress& progress) const
{
    Camera dense = camera;
    dense.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width * options_.samples_per_side,
                                                   camera.intrinsics.height * options_.samples_per_side);
    Raster8 image(camera.intrinsics.width, camera.intrinsics.height, 4);
    constexpr std::size_t rows_per_block = 8;
    parallel_for(static_cast<std::size_t>(camera.intrinsics.height), rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     render_rows(camera, dense, static_cast<int>(begin), static_cast<int>(end), image);
                 });
    return image;
}

}  // namespace fresco::raycast
