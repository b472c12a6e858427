#include <fresco/error.h>
#include <fresco/parallel.h>
#include <fresco/raycast/view_renderer.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

namespace fresco::raycast
{

namespace
{
constexpr float steps_per_unit = 257;  // 255 becomes 65535

Raster16 stored(const RasterF& values)
{
    Raster16 result(values.width, values.height, 3);
    std::transform(values.values.begin(), values.values.end(), result.values.begin(),
                   [](float v) { return static_cast<std::uint16_t>(std::clamp(v * steps_per_unit + 0.5F, 0.0F, 65535.0F)); });
    return result;
}

RasterF halved(const RasterF& level)
{
    return resized(level, std::max(1, level.width / 2), std::max(1, level.height / 2));
}

/// The same of a picture: one with even sides, such as any large texture, is never held as floats, which take four times its
/// size.
RasterF halved(const Raster8& picture)
{
    if (picture.width % 2 != 0 || picture.height % 2 != 0)
    {
        RasterF level(picture.width, picture.height, 3);
        std::copy(picture.values.begin(), picture.values.end(), level.values.begin());
        return halved(level);
    }
    RasterF result(picture.width / 2, picture.height / 2, 3);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            for (int c = 0; c < 3; ++c)
            {
                const auto sum = [&](int row) { return picture.at(2 * x, row, c) + picture.at(2 * x + 1, row, c); };
                result.at(x, y, c) = static_cast<float>(sum(2 * y) + sum(2 * y + 1)) / 4;
            }
    return result;
}

/// Bilinear, in the raster's own steps.
template <class T>
Vec3d sampled(const Raster<T>& texels, Vec2d uv)
{
    const double x = std::clamp(uv.x * texels.width - 0.5, 0.0, texels.width - 1.0);
    const double y = std::clamp((1 - uv.y) * texels.height - 0.5, 0.0, texels.height - 1.0);
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, texels.width - 1);
    const int y1 = std::min(y0 + 1, texels.height - 1);
    const auto texel = [&](int tx, int ty)
    {
        const T* rgb = &texels.at(tx, ty);
        return Vec3d{double(rgb[0]), double(rgb[1]), double(rgb[2])};
    };
    const Vec3d top = texel(x0, y0) * (x0 + 1 - x) + texel(x1, y0) * (x - x0);
    const Vec3d bottom = texel(x0, y1) * (x0 + 1 - x) + texel(x1, y1) * (x - x0);
    return top * (y0 + 1 - y) + bottom * (y - y0);
}
}  // namespace

MipMaps::MipMaps(Raster8 picture, TextureFilter filter) : picture_(std::move(picture))
{
    if (picture_.channels != 3 || picture_.empty())
        throw Error(fmt::format("the picture has {} channels; expected 3 (RGB)", picture_.channels));
    if (filter == TextureFilter::bilinear || (picture_.width == 1 && picture_.height == 1))
        return;
    RasterF level = halved(picture_);
    smaller_.push_back(stored(level));
    while (level.width > 1 || level.height > 1)
    {
        level = halved(level);
        smaller_.push_back(stored(level));
    }
}

Vec3d MipMaps::sample_level(Vec2d uv, std::size_t level) const
{
    return level == 0 ? sampled(picture_, uv) : sampled(smaller_[level - 1], uv) * (1.0 / double{steps_per_unit});
}

Vec3d MipMaps::sample(Vec2d uv, double lod) const
{
    const double at = std::clamp(lod, 0.0, static_cast<double>(smaller_.size()));
    const auto level = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(level);
    const Vec3d fine = sample_level(uv, level);
    return share > 0 ? fine * (1 - share) + sample_level(uv, level + 1) * share : fine;
}

FilterOption::FilterOption(Configurable* owner)
    : word_(owner, "filter", "trilinear", one_of({"trilinear", "bilinear"}),
            "Texture lookup: trilinear uses mip-maps where a ray skips texels, bilinear always the full picture")
{
}

Option<int> samples_option(Configurable* owner)
{
    return {owner, "samples", 2, range(1, 8), "Rays per pixel along each side, against aliasing at edges and far away"};
}

Option<std::string> shading_option(Configurable* owner, std::string help)
{
    return {owner, "shading", "none", one_of({"none", "scannet", "matterport3d"}), std::move(help)};
}

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
    : options_(options), scene_(mesh.mesh), texture_(mesh.image.pixels, options.filter), lighting_(mesh.mesh, options.lights)
{
}

double ViewRenderer::level_of_detail(const Camera& dense, int x, int y, const Hit& hit, Vec2d uv) const
{
    if (options_.filter == TextureFilter::bilinear)
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
