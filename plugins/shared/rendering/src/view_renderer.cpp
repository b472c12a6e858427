#include <fresco/error.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/uv_mapping/into_camera.h>
#include <fresco/uv_mapping/shading.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fmt/format.h>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

// The same operations in the same order, with the instructions that this processor has.
// A sanitizer cannot watch the choice between them, which is made before it starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__) &&                          \
    !defined(__SANITIZE_ADDRESS__)
#define FRESCO_WIDE_VECTORS __attribute__((target_clones("avx2", "default"), flatten))
#else
#define FRESCO_WIDE_VECTORS
#endif

namespace fresco::rendering
{

namespace
{
constexpr float steps_per_unit = 257;  // 255 becomes 65535

Raster16 stored(const RasterF& values)
{
    Raster16 result(values.width, values.height, 4);
    for (std::size_t texel = 0; texel < values.values.size() / 3; ++texel)
        for (std::size_t c = 0; c < 3; ++c)
            result.values[4 * texel + c] =
                static_cast<std::uint16_t>(std::clamp(values.values[3 * texel + c] * steps_per_unit + 0.5F, 0.0F, 65535.0F));
    return result;
}

Raster8 with_four_channels(const Raster8& picture)
{
    Raster8 result(picture.width, picture.height, 4);
    for (std::size_t texel = 0; texel < picture.values.size() / 3; ++texel)
        std::copy_n(&picture.values[3 * texel], 3, &result.values[4 * texel]);
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

typedef std::int32_t FourInts __attribute__((vector_size(16)));

// Compilers convert vectors of short integers one by one.
MipMaps::Color loaded(const std::uint8_t* texel)
{
    std::int32_t all;
    std::memcpy(&all, texel, sizeof all);
    return __builtin_convertvector((FourInts{} + all) >> FourInts{0, 8, 16, 24} & 0xFF, MipMaps::Color);
}

MipMaps::Color loaded(const std::uint16_t* texel)
{
    std::int32_t red_green;
    std::int32_t blue;
    std::memcpy(&red_green, texel, sizeof red_green);
    std::memcpy(&blue, texel + 2, sizeof blue);
    return __builtin_convertvector(FourInts{red_green, red_green, blue, blue} >> FourInts{0, 16, 0, 16} & 0xFFFF, MipMaps::Color);
}

/// Bilinear, in the raster's own steps.
template <class T>
MipMaps::Color sampled(const Raster<T>& texels, Vec2d uv)
{
    return numerics::bilinear(numerics::between<float>(uv.x * texels.width - 0.5, texels.width),
                              numerics::between<float>((1 - uv.y) * texels.height - 0.5, texels.height),
                              [&](int x, int y) { return loaded(&texels.at(x, y)); });
}
}  // namespace

MipMaps::MipMaps(const Raster8& picture, TextureFilter filter)
{
    if (picture.channels != 3 || picture.empty())
        throw Error(fmt::format("the picture has {} channels; expected 3 (RGB)", picture.channels));
    picture_ = with_four_channels(picture);
    if (filter == TextureFilter::bilinear || (picture.width == 1 && picture.height == 1))
        return;
    RasterF level = halved(picture);
    smaller_.push_back(stored(level));
    while (level.width > 1 || level.height > 1)
    {
        level = halved(level);
        smaller_.push_back(stored(level));
    }
}

MipMaps::Color MipMaps::color_of_level(Vec2d uv, std::size_t level) const
{
    return level == 0 ? sampled(picture_, uv) : sampled(smaller_[level - 1], uv) * (1 / steps_per_unit);
}

MipMaps::Color MipMaps::color(Vec2d uv, double lod) const
{
    const double at = std::clamp(lod, 0.0, static_cast<double>(smaller_.size()));
    const auto level = static_cast<std::size_t>(at);
    const auto share = static_cast<float>(at - static_cast<double>(level));
    const Color fine = color_of_level(uv, level);
    return share > 0 ? fine * (1 - share) + color_of_level(uv, level + 1) * share : fine;
}

Vec3d MipMaps::sample(Vec2d uv, double lod) const
{
    const Color found = color(uv, lod);
    return {double{found[0]}, double{found[1]}, double{found[2]}};
}

FilterOption::FilterOption(Configurable* owner)
    : filter_(owner, "filter", TextureFilter::trilinear,
              {{"trilinear", TextureFilter::trilinear},
               {"anisotropic", TextureFilter::anisotropic},
               {"bilinear", TextureFilter::bilinear}},
              "Texture lookup: trilinear uses mip-maps where a sample skips texels, anisotropic several places in larger ones on "
              "slanted surface, bilinear "
              "always the full picture")
{
}

Option<int> samples_option(Configurable* owner)
{
    return {owner, "samples", 2, range(1, 8), "Samples per pixel along each side, against aliasing at edges and far away"};
}

Option<std::string> shading_option(Configurable* owner, std::string help)
{
    return {owner, "shading", "none", one_of({"none", "scannet", "matterport3d"}), std::move(help)};
}

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

double Lighting::at(std::uint32_t face, const std::array<double, 3>& weights) const
{
    if (normals_.empty())
        return lights_.ambient;
    Vec3d sum;
    for (std::size_t corner = 0; corner < 3; ++corner)
        sum += vec_cast<double>(normals_[mesh_.triangles[face][corner]]) * weights[corner];
    return lights_.ambient + lights_.diffuse * std::max(0.0, dot(normalized(sum), lights_.toward));
}

namespace
{

/// Along the rows, and down the columns of samples.
typedef double Two __attribute__((vector_size(16)));

/// A number that is linear in the picture: its steps to the next samples, and itself at the center of the first.
struct Linear
{
    Two steps{};
    double first = 0;

    double at(double x, double y) const { return steps[0] * x + steps[1] * y + first; }
};

/// What a face has to a camera's samples. A ray meets the plane of the corners p0, p1, p2 (in the camera's frame) where its
/// direction d has the weights M⁻¹ d, of M = (p0 p1 p2), divided by their sum, which is one over the depth: ratios of linear
/// numbers, also for the texcoord (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997).
struct FacePlane
{
    std::uint32_t face = no_face;
    bool is_front = false;
    std::array<Linear, 3> weights{};
    Linear nearness{};  ///< Their sum: 1 / depth.
    Linear u{};         ///< Texels from the left border, times nearness.
    Linear v{};         ///< Texels from the lower border, times nearness.
    double u_low = 0;   ///< Bounds of the corners' texels.
    double u_high = 0;
    double v_low = 0;
    double v_high = 0;
};

FacePlane plane_of(const Mesh& mesh, std::uint32_t face, const IntoCamera& into_camera, const Intrinsics& k, Vec2d texels)
{
    const Triangle& t = mesh.triangles[face];
    const std::array<Vec3d, 3> p{into_camera.point(mesh.positions[t[0]]), into_camera.point(mesh.positions[t[1]]),
                                 into_camera.point(mesh.positions[t[2]])};
    FacePlane plane;
    plane.face = face;
    const double determinant = dot(p[0], cross(p[1], p[2]));
    // Seen from its front, a face's corners run counterclockwise. Its plane may hold the camera: then nothing of it is seen.
    plane.is_front = determinant < 0;
    if (!plane.is_front)
        return plane;
    const auto add = [](Linear& sum, const Linear& term, double factor)
    {
        sum.steps += term.steps * factor;
        sum.first += term.first * factor;
    };
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
        const Vec3d row = cross(p[(corner + 1) % 3], p[(corner + 2) % 3]) * (1 / determinant);
        Linear& weight = plane.weights[corner];
        weight.steps = Two{row.x / k.fx, row.y / k.fy};
        weight.first = row.z + weight.steps[0] * (0.5 - k.cx) + weight.steps[1] * (0.5 - k.cy);
        const Vec2f uv = mesh.texcoords[3 * std::size_t{face} + corner];
        const Vec2d texel{double{uv.x} * texels.x, double{uv.y} * texels.y};
        add(plane.nearness, weight, 1);
        add(plane.u, weight, texel.x);
        add(plane.v, weight, texel.y);
        plane.u_low = corner == 0 ? texel.x : std::min(plane.u_low, texel.x);
        plane.u_high = corner == 0 ? texel.x : std::max(plane.u_high, texel.x);
        plane.v_low = corner == 0 ? texel.y : std::min(plane.v_low, texel.y);
        plane.v_high = corner == 0 ? texel.y : std::max(plane.v_high, texel.y);
    }
    return plane;
}

/// Planes of the faces that were seen last: the pixels around see them, too.
class PlaneCache
{
  public:
    const FacePlane& plane(const Mesh& mesh, std::uint32_t face, const IntoCamera& into_camera, const Intrinsics& k, Vec2d texels)
    {
        FacePlane& kept = planes_[face % planes_.size()];
        if (kept.face != face)
            kept = plane_of(mesh, face, into_camera, k, texels);
        return kept;
    }

  private:
    std::vector<FacePlane> planes_{std::vector<FacePlane>(1024)};
};

/// What a sample looks up.
struct Footprint
{
    double lod = 0;
    int places = 1;  ///< Spread along …
    Vec2d along;     ///< … this, in texels, around the texel.
};

/// From how far apart two neighboring samples look a texture up. (u, v): the texel here.
Footprint footprint(const FacePlane& plane, double nearness, double u, double v, TextureFilter filter)
{
    // Of the two samples to the right and below, whichever is farther, on the face's plane: (u' + s) / (n + m) - u' / n, of u' =
    // u n.
    const Two there = nearness + plane.nearness.steps;
    const Two du = (plane.u.steps - u * plane.nearness.steps) / there;
    const Two dv = (plane.v.steps - v * plane.nearness.steps) / there;
    const Two squared = du * du + dv * dv;
    // One beyond the face's horizon does not count.
    const double across = there[0] > 0 ? squared[0] : 0;
    const double down = there[1] > 0 ? squared[1] : 0;
    double texels = std::max(across, down);
    Footprint print;
    if (filter == TextureFilter::anisotropic)
    {
        // After EXT_texture_filter_anisotropic.
        constexpr double most_places = 8;
        const double ratio = std::sqrt(texels / std::max(1.0, std::min(across, down)));
        print.places = static_cast<int>(std::clamp(std::ceil(ratio), 1.0, most_places));
        print.along = across >= down ? Vec2d{du[0], dv[0]} : Vec2d{du[1], dv[1]};
        texels /= print.places * print.places;
    }
    print.lod = texels > 1 ? 0.5 * double{std::log2(static_cast<float>(texels))} : 0;
    return print;
}

std::uint8_t rounded(float v)
{
    return static_cast<std::uint8_t>(std::clamp(v + 0.5F, 0.0F, 255.0F));
}

/// Draws the pixels of some rows from the faces that their samples see. `camera` is that of the samples.
struct RowPainter
{
    const Mesh& mesh;
    const RenderOptions& options;
    const MipMaps& texture;
    const Lighting& lighting;
    const Camera& camera;
    const FaceMap& faces;  ///< Of rows of samples from `first_sample_row` on.

    FRESCO_WIDE_VECTORS void paint(int first_row, int end_row, int first_sample_row, Raster8& image) const
    {
        constexpr int columns = 32;
        const IntoCamera into_camera(camera.world_from_camera);
        PlaneCache planes;
        // In tiles: the rows of one see the same faces.
        for (int first = 0; first < image.width; first += columns)
            for (int y = first_row; y < end_row; ++y)
                for (int x = first; x < std::min(first + columns, image.width); ++x)
                    paint_pixel(x, y, first_sample_row, into_camera, planes, image);
    }

  private:
    void paint_pixel(int x, int y, int first_sample_row, const IntoCamera& into_camera, PlaneCache& planes, Raster8& image) const
    {
        const int side = options.samples_per_side;
        const Vec2d texels{double(texture.width()), double(texture.height())};
        MipMaps::Color sum{};
        int found = 0;
        for (int sample_y = y * side; sample_y < (y + 1) * side; ++sample_y)
            for (int sample_x = x * side; sample_x < (x + 1) * side; ++sample_x)
            {
                const std::uint32_t face = faces.at(sample_x, sample_y - first_sample_row);
                if (face != no_face)
                    found +=
                        add_sample(planes.plane(mesh, face, into_camera, camera.intrinsics, texels), sample_x, sample_y, sum);
            }
        if (found == 0)
            return;
        std::uint8_t* rgba = &image.at(x, y);
        for (int c = 0; c < 3; ++c)
            rgba[c] = rounded(sum[c] / static_cast<float>(found));
        rgba[3] = rounded(255 * static_cast<float>(found) / static_cast<float>(side * side));
    }

    int add_sample(const FacePlane& plane, double x, double y, MipMaps::Color& sum) const
    {
        if (!plane.is_front)
            return 0;
        const double nearness = plane.nearness.at(x, y);
        const double depth = 1 / nearness;
        if (depth < nearest_surface_m)
            return 0;
        double u = plane.u.at(x, y) * depth;
        double v = plane.v.at(x, y) * depth;
        const Footprint print =
            options.filter == TextureFilter::bilinear ? Footprint{} : footprint(plane, nearness, u, v, options.filter);
        // A sample on the border of a face may miss it by a rounding; it then shows the nearest point.
        if (u < plane.u_low || u > plane.u_high || v < plane.v_low || v > plane.v_high)
            weights_inside(plane, x, y, u, v);
        MipMaps::Color color{};
        for (int i = 1; i <= print.places; ++i)
        {
            const double share = static_cast<double>(i) / (print.places + 1) - 0.5;
            color += texture.color(
                {(u + share * print.along.x) / texture.width(), (v + share * print.along.y) / texture.height()}, print.lod);
        }
        color *= 1 / static_cast<float>(print.places);
        if (options.lights.diffuse > 0)
        {
            color *= static_cast<float>(lighting.at(plane.face, weights_inside(plane, x, y, u, v)));
            color = color < 255 ? color : MipMaps::Color{} + 255;
        }
        sum += color;
        return 1;
    }

    /// Of the face's corners, none negative; (u, v) is moved to the texel there.
    std::array<double, 3> weights_inside(const FacePlane& plane, double x, double y, double& u, double& v) const
    {
        std::array<double, 3> weights;
        double total = 0;
        for (std::size_t corner = 0; corner < 3; ++corner)
            total += weights[corner] = std::max(plane.weights[corner].at(x, y), 0.0);
        u = v = 0;
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            weights[corner] /= total;
            const Vec2f uv = mesh.texcoords[3 * std::size_t{plane.face} + corner];
            u += weights[corner] * double{uv.x} * texture.width();
            v += weights[corner] * double{uv.y} * texture.height();
        }
        return weights;
    }
};

/// Bounds what a view's samples take: 16 MB.
constexpr int most_samples = 1 << 22;

/// Work that is one thread's.
class Alone final : public Progress
{
  public:
    explicit Alone(const Progress& outer) : outer_(outer) {}
    void check_canceled() const override { outer_.check_canceled(); }
    int threads() const override { return 1; }

  private:
    const Progress& outer_;
};

}  // namespace

struct ViewRenderer::Workspace
{
    Workspace(const Mesh& mesh, const RenderOptions& options) : finder(mesh, options.through_backs) {}
    RasterFinder finder;
    std::vector<FaceMap> faces{1};
};

struct ViewRenderer::Idle
{
    std::mutex mutex;
    std::vector<std::unique_ptr<Workspace>> workspaces;
};

ViewRenderer::ViewRenderer(const TexturedMesh& mesh, const RenderOptions& options)
    : mesh_(mesh.mesh), options_(options), texture_(mesh.image.pixels, options.filter), lighting_(mesh.mesh, options.lights),
      idle_(std::make_unique<Idle>())
{
}

ViewRenderer::~ViewRenderer() = default;

Raster8 ViewRenderer::render(const Camera& camera, const Progress& progress) const
{
    std::unique_ptr<Workspace> work;
    {
        const std::lock_guard lock(idle_->mutex);
        if (!idle_->workspaces.empty())
        {
            work = std::move(idle_->workspaces.back());
            idle_->workspaces.pop_back();
        }
    }
    if (work == nullptr)
        work = std::make_unique<Workspace>(mesh_, options_);

    const int side = options_.samples_per_side;
    const Intrinsics& size = camera.intrinsics;
    Camera samples = camera;
    samples.intrinsics = size.scaled_to(size.width * side, size.height * side);
    Raster8 image(size.width, size.height, 4);
    const int band = std::clamp(most_samples / (samples.intrinsics.width * side), 1, size.height);
    for (int first = 0; first < size.height; first += band)
    {
        const int rows = std::min(band, size.height - first);
        Camera part = samples;
        part.intrinsics.height = rows * side;
        part.intrinsics.cy -= first * side;
        if (FaceMap& faces = work->faces.front(); faces.width != part.intrinsics.width || faces.height != part.intrinsics.height)
            faces = FaceMap(part.intrinsics.width, part.intrinsics.height);
        work->finder.find(std::span(&part, 1), progress, work->faces);
        const RowPainter painter{mesh_, options_, texture_, lighting_, samples, work->faces.front()};
        constexpr std::size_t rows_per_block = 16;
        parallel_for(static_cast<std::size_t>(rows), rows_per_block, progress.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         progress.check_canceled();
                         painter.paint(first + static_cast<int>(begin), first + static_cast<int>(end), first * side, image);
                     });
    }
    const std::lock_guard lock(idle_->mutex);
    idle_->workspaces.push_back(std::move(work));
    return image;
}

void ViewRenderer::render_each(std::span<const Camera> cameras, Progress& progress,
                               const std::function<void(std::size_t, const Raster8&)>& take) const
{
    const Alone alone(progress);
    parallel_for_each(cameras.size(), "views", progress, [&](std::size_t i) { take(i, render(cameras[i], alone)); });
}

void ViewRenderer::render_in_order(std::span<const Camera> cameras, Progress& progress,
                                   const std::function<void(const Raster8&)>& take) const
{
    const Alone alone(progress);
    const auto at_once = static_cast<std::size_t>(progress.threads());
    std::vector<Raster8> rendered;
    for (std::size_t first = 0; first < cameras.size() + at_once; first += at_once)
    {
        const auto next = cameras.subspan(std::min(first, cameras.size()));
        std::vector<Raster8> coming(std::min(at_once, next.size()));
        parallel_for(1 + coming.size(), 1, progress.threads(),
                     [&](std::size_t task, std::size_t)
                     {
                         if (task == 0)
                             std::ranges::for_each(rendered, take);
                         else
                             coming[task - 1] = render(next[task - 1], alone);
                     });
        rendered = std::move(coming);
        progress.progress(static_cast<double>(std::min(first, cameras.size())), static_cast<double>(cameras.size()), "views");
    }
}

}  // namespace fresco::rendering
