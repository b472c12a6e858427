#include <fresco/parallel.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/uv_mapping/into_camera.h>
#include <fresco/uv_mapping/shading.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace fresco::rendering
{

Choice<TextureFilter> filter_option(Configurable* owner)
{
    return {owner,
            "filter",
            TextureFilter::trilinear,
            {{"trilinear", TextureFilter::trilinear},
             {"anisotropic", TextureFilter::anisotropic},
             {"bilinear", TextureFilter::bilinear}},
            "Texture lookup: trilinear uses mip-maps where a sample skips texels, anisotropic several places in larger ones on "
            "slanted surface, bilinear always the full picture"};
}

Option<std::string> shading_option(Configurable* owner, const std::string& help)
{
    return {owner, "shading", "none", one_of({"none", "scannet", "matterport3d"}), help};
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

/// A number that is linear in the picture: its steps to the next samples, and itself at the center of the first.
struct Linear
{
    double right = 0;
    double down = 0;
    double first = 0;

    double at(double x, double y) const { return right * x + down * y + first; }
    void add(const Linear& term, double factor)
    {
        right += term.right * factor;
        down += term.down * factor;
        first += term.first * factor;
    }
};

/// Texture lookup of a sample.
struct Footprint
{
    double squared = 0;  ///< Distance to the next sample, or a place of several, in texels, squared.
    int places = 1;      ///< Spread along …
    Vec2d along;         ///< … this, in texels, around the texel.
};

/// Plane of a face as a camera's samples see it. A ray meets the plane of the corners p0, p1, p2 (in the camera's frame) where
/// its direction d has the weights M⁻¹ d, of M = (p0 p1 p2), divided by their sum, which is one over the depth: ratios of linear
/// numbers, also for the texcoord (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997).
struct FacePlane
{
    std::uint32_t face = no_face;
    bool is_front = false;
    bool is_small = false;  ///< One footprint does for all of it: it is far away for its size.
    Linear nearness{};      ///< The sum of the weights: 1 / depth.
    Linear u{};             ///< Texels from the left border, times nearness.
    Linear v{};             ///< Texels from the lower border, times nearness.
    double u_low = 0;       ///< Bounds of the corners' texels.
    double u_high = 0;
    double v_low = 0;
    double v_high = 0;
    Footprint footprint{};  ///< If small.
    std::array<Linear, 3> weights{};
};

constexpr int most_places = 8;  ///< Most lookups of a footprint.

/// From how far apart two neighboring samples look a texture up. (u, v): the texel here.
inline Footprint footprint(const FacePlane& plane, double nearness, double u, double v, TextureFilter filter)
{
    if (filter == TextureFilter::bilinear)
        return {};
    // Takes the farther of the samples to the right and below, on the face's plane: (u' + s) / (n + m) - u' / n, with u' =
    // u n.
    typedef double Two __attribute__((vector_size(16)));
    const Two step{plane.nearness.right, plane.nearness.down};
    const Two there = nearness + step;
    const Two du = (Two{plane.u.right, plane.u.down} - u * step) / there;
    const Two dv = (Two{plane.v.right, plane.v.down} - v * step) / there;
    const Two squared = du * du + dv * dv;
    // One beyond the face's horizon does not count.
    const double across = there[0] > 0 ? squared[0] : 0;
    const double down = there[1] > 0 ? squared[1] : 0;
    Footprint print;
    print.squared = std::max(across, down);
    if (filter == TextureFilter::anisotropic)
    {
        // After EXT_texture_filter_anisotropic.
        const double ratio = std::sqrt(print.squared / std::max(1.0, std::min(across, down)));
        print.places = static_cast<int>(std::clamp(std::ceil(ratio), 1.0, double{most_places}));
        print.along = across >= down ? Vec2d{du[0], dv[0]} : Vec2d{du[1], dv[1]};
        print.squared /= print.places * print.places;
    }
    return print;
}

void place(FacePlane& plane, const Mesh& mesh, std::uint32_t face, const IntoCamera& into_camera, const Intrinsics& k,
           Vec2d texels, TextureFilter filter)
{
    const Triangle& t = mesh.triangles[face];
    const std::array<Vec3d, 3> p{into_camera.point(mesh.positions[t[0]]), into_camera.point(mesh.positions[t[1]]),
                                 into_camera.point(mesh.positions[t[2]])};
    plane.face = face;
    const double determinant = dot(p[0], cross(p[1], p[2]));
    // Seen from its front, a face's corners run counterclockwise. Its plane may hold the camera: then nothing of it is seen.
    plane.is_front = determinant < 0;
    if (!plane.is_front)
        return;
    plane.nearness = plane.u = plane.v = {};
    Vec2d middle;
    const double per_determinant = 1 / determinant;
    const double per_x = 1 / k.fx;
    const double per_y = 1 / k.fy;
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
        const Vec3d row = cross(p[(corner + 1) % 3], p[(corner + 2) % 3]) * per_determinant;
        Linear& weight = plane.weights[corner];
        weight.right = row.x * per_x;
        weight.down = row.y * per_y;
        weight.first = row.z + weight.right * (0.5 - k.cx) + weight.down * (0.5 - k.cy);
        const Vec2f uv = mesh.texcoords[3 * std::size_t{face} + corner];
        const Vec2d texel{double{uv.x} * texels.x, double{uv.y} * texels.y};
        plane.nearness.add(weight, 1);
        plane.u.add(weight, texel.x);
        plane.v.add(weight, texel.y);
        middle = middle + texel * (1.0 / 3);
        plane.u_low = corner == 0 ? texel.x : std::min(plane.u_low, texel.x);
        plane.u_high = corner == 0 ? texel.x : std::max(plane.u_high, texel.x);
        plane.v_low = corner == 0 ? texel.y : std::min(plane.v_low, texel.y);
        plane.v_high = corner == 0 ? texel.y : std::max(plane.v_high, texel.y);
    }
    // Texels per sample grow with depth, and with its square where the surface is slanted.
    constexpr double most_change = 0.01;
    const auto [nearest, farthest] = std::minmax({p[0].z, p[1].z, p[2].z});
    plane.is_small = filter == TextureFilter::bilinear || (nearest > 0 && farthest < nearest * (1 + most_change));
    if (plane.is_small)
        plane.footprint = footprint(plane, 3 / (p[0].z + p[1].z + p[2].z), middle.x, middle.y, filter);
}

/// Planes of the faces that were seen last: the pixels around see them, too.
class PlaneCache
{
  public:
    /// `texels`: the size of the texture.
    PlaneCache(const Mesh& mesh, const Camera& camera, Vec2d texels, TextureFilter filter)
        : mesh_(mesh), into_camera_(camera.world_from_camera), intrinsics_(camera.intrinsics), texels_(texels), filter_(filter)
    {
    }

    const FacePlane& plane(std::uint32_t face)
    {
        FacePlane& kept = planes_[face % size];
        if (kept.face != face)
            place(kept, mesh_, face, into_camera_, intrinsics_, texels_, filter_);
        return kept;
    }

  private:
    static constexpr std::size_t size = 1024;

    const Mesh& mesh_;
    IntoCamera into_camera_;
    Intrinsics intrinsics_;
    Vec2d texels_;
    TextureFilter filter_;
    std::vector<FacePlane> planes_{std::vector<FacePlane>(size)};
};

std::uint8_t rounded(float v)
{
    return static_cast<std::uint8_t>(std::clamp(v + 0.5F, 0.0F, 255.0F));
}

/// Draws the pixels of some rows from the faces that their samples see. `camera` is that of the samples.
class RowPainter
{
  public:
    RowPainter(const Mesh& mesh, const RenderOptions& options, const MipMaps& texture, const Lighting& lighting,
               const Camera& camera, const FaceMap& faces, int first_sample_row)
        : mesh_(mesh), options_(options), lighting_(lighting), faces_(faces),
          first_sample_row_(first_sample_row), texels_{double(texture.width()), double(texture.height())},
          planes_(mesh, camera, texels_, options.filter), lookups_(texture)
    {
    }

    void paint(int first_row, int end_row, Raster8& image)
    {
        constexpr int columns = 32;
        // In tiles: the rows of one see the same faces.
        for (int first = 0; first < image.width; first += columns)
            for (int y = first_row; y < end_row; ++y)
                paint_pixels(first, std::min(first + columns, image.width), y, image);
    }

  private:
    /// Places of the lookups that are lit alike: those of a sample, or where nothing is shaded, of all samples of a pixel.
    struct Group
    {
        std::size_t places;
        float light;
    };

    void paint_pixels(int first, int end, int y, Raster8& image)
    {
        const int side = options_.samples_per_side;
        lookups_.start(static_cast<std::size_t>(end - first) * side * side *
                       (options_.filter == TextureFilter::anisotropic ? most_places : 1));
        groups_.clear();
        found_.clear();
        for (int x = first; x < end; ++x)
        {
            const std::size_t before = lookups_.count();
            const int found = add_pixel(x, y);
            found_.push_back(found);
            if (!is_shaded_ && found > 0)
                groups_.push_back({lookups_.count() - before, 1});
        }
        lookups_.look_up();
        const std::array<const float*, 3> colors{lookups_.colors(0).data(), lookups_.colors(1).data(), lookups_.colors(2).data()};
        std::size_t place = 0;
        auto group = groups_.begin();
        for (int x = first; x < end; ++x)
        {
            const int found = found_[static_cast<std::size_t>(x - first)];
            if (found == 0)
                continue;
            std::array<float, 3> sum{};
            const auto end_group = group + (is_shaded_ ? found : 1);
            for (; group != end_group; ++group)
            {
                std::array<float, 3> color{};
                for (const std::size_t end_place = place + group->places; place < end_place; ++place)
                {
                    color[0] += colors[0][place];
                    color[1] += colors[1][place];
                    color[2] += colors[2][place];
                }
                if (is_shaded_)
                    for (float& value : color)
                        value = std::min(value * group->light, 255.0F);
                sum[0] += color[0];
                sum[1] += color[1];
                sum[2] += color[2];
            }
            std::uint8_t* rgba = &image.at(x, y);
            const float share = 1 / static_cast<float>(found);
            rgba[0] = rounded(sum[0] * share);
            rgba[1] = rounded(sum[1] * share);
            rgba[2] = rounded(sum[2] * share);
            rgba[3] = rounded(255 * static_cast<float>(found) / static_cast<float>(side * side));
        }
    }

    /// How many of the pixel's samples see a face.
    int add_pixel(int x, int y)
    {
        const int side = options_.samples_per_side;
        const auto for_each_sample = [&](const auto& visit)
        {
            for (int row = y * side; row < (y + 1) * side; ++row)
                for (int column = x * side; column < (x + 1) * side; ++column)
                    visit(faces_.at(column, row - first_sample_row_), column, row);
        };
        const std::uint32_t first = faces_.at(x * side, y * side - first_sample_row_);
        bool is_one_face = is_joined_;
        for_each_sample([&](std::uint32_t face, int, int) { is_one_face &= face == first; });
        if (is_one_face)
            return add_samples(first, (x + 0.5) * side - 0.5, (y + 0.5) * side - 0.5, side);
        int found = 0;
        for_each_sample([&](std::uint32_t face, int column, int row) { found += add_samples(face, column, row, 1); });
        return found;
    }

    /// Adds one lookup for side x side samples around (x, y), and returns how many of them see the face.
    int add_samples(std::uint32_t face, double x, double y, int side)
    {
        if (face == no_face)
            return 0;
        const FacePlane& plane = planes_.plane(face);
        const double nearness = plane.nearness.at(x, y);
        const double depth = 1 / nearness;
        if (!plane.is_front || depth < nearest_surface_m)
            return 0;
        double u = plane.u.at(x, y) * depth;
        double v = plane.v.at(x, y) * depth;
        // A sample on the border of a face may miss it by a rounding; it then shows the nearest point.
        if (u < plane.u_low || u > plane.u_high || v < plane.v_low || v > plane.v_high)
            weights_inside(plane, x, y, u, v);
        const std::size_t before = lookups_.count();
        Footprint own;
        if (!plane.is_small)
            own = footprint(plane, nearness, u, v, options_.filter);
        const Footprint& print = plane.is_small ? plane.footprint : own;
        // A lookup at the distance of pixels blurs more than the mean of samples.
        const double squared = side > 1 ? 0.6 * side * side * print.squared : print.squared;
        const double lod = squared > 1 ? 0.5 * double{std::log2(static_cast<float>(squared))} : 0;
        const float weight = static_cast<float>(side * side) / static_cast<float>(print.places);
        for (int i = 1; i <= print.places; ++i)
        {
            const double share = (static_cast<double>(i) / (print.places + 1) - 0.5) * side;
            lookups_.add(u + share * print.along.x, v + share * print.along.y, lod, weight);
        }
        if (is_shaded_)
            groups_.push_back(
                {lookups_.count() - before, static_cast<float>(lighting_.at(plane.face, weights_inside(plane, x, y, u, v)))});
        return side * side;
    }

    /// Weights of the face's corners, none negative; (u, v) is moved to the texel there.
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
            const Vec2f uv = mesh_.texcoords[3 * std::size_t{plane.face} + corner];
            u += weights[corner] * double{uv.x} * texels_.x;
            v += weights[corner] * double{uv.y} * texels_.y;
        }
        return weights;
    }

    const Mesh& mesh_;
    const RenderOptions& options_;
    const Lighting& lighting_;
    const FaceMap& faces_;  ///< Faces of the rows of samples from `first_sample_row_` on.
    int first_sample_row_;
    Vec2d texels_;
    PlaneCache planes_;
    Lookups lookups_;
    bool is_shaded_ = options_.lights.diffuse > 0;
    /// A pixel on one face is looked up once, in a smaller picture.
    bool is_joined_ = !is_shaded_ && options_.samples_per_side > 1 && options_.filter != TextureFilter::bilinear;
    std::vector<Group> groups_;
    std::vector<int> found_;  ///< Samples of each pixel.
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
    explicit Workspace(const RasterFinder& first) : finder(first) {}
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
      finder_(std::make_unique<RasterFinder>(mesh.mesh, options.through_backs)), idle_(std::make_unique<Idle>())
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
        work = std::make_unique<Workspace>(*finder_);

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
        // One thread goes down the whole picture, whose next rows see the same faces.
        const std::size_t rows_per_block = progress.threads() > 1 ? 16 : static_cast<std::size_t>(rows);
        parallel_for(static_cast<std::size_t>(rows), rows_per_block, progress,
                     [&](std::size_t begin, std::size_t end)
                     {
                         progress.check_canceled();
                         RowPainter painter(mesh_, options_, texture_, lighting_, samples, work->faces.front(), first * side);
                         painter.paint(first + static_cast<int>(begin), first + static_cast<int>(end), image);
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
    const std::size_t together = 2 * static_cast<std::size_t>(std::max(1, progress.threads()));
    std::vector<Raster8> before;
    std::size_t taken = 0;
    for (std::size_t first = 0; taken < cameras.size(); first += together)
    {
        const auto next = cameras.subspan(std::min(first, cameras.size()));
        std::vector<Raster8> pictures(std::min(together, next.size()));
        const auto take_before = [&]
        {
            for (const Raster8& picture : before)
            {
                take(picture);
                progress.progress(static_cast<double>(++taken), static_cast<double>(cameras.size()), "views");
            }
        };
        parallel_items(pictures.size() + 1, 1, progress,
                       [&](std::size_t i) { i == 0 ? take_before() : void(pictures[i - 1] = render(next[i - 1], alone)); });
        before = std::move(pictures);
    }
}

}  // namespace fresco::rendering
