#include <fresco/splats/render_splats.h>

#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace fresco::splats
{
namespace
{

/// Four pixels of a row.
typedef float Quad __attribute__((vector_size(16)));
typedef std::int32_t Mask __attribute__((vector_size(16)));
constexpr int quad = 4;
constexpr int tile = 16;

constexpr float least_alpha = 1.0F / 255;
constexpr float most_alpha = 0.99F;
/// A tile with less transmittance than this is finished.
constexpr float opaque = 1e-4F;
/// Variance of the pixel's own filter.
constexpr double pixel_variance = 0.3;
/// Footprints are linearized no farther outside of the picture, relative to its half side.
constexpr double farthest_outside = 1.3;
constexpr std::size_t projected_at_once = 4096;
/// Gaussians between two looks at whether a tile is opaque.
constexpr std::size_t drawn_at_once = 16;

/// A Gaussian in the picture.
struct Footprint
{
    float x = 0, y = 0;            ///< Pixels.
    float xx = 0, xy = 0, yy = 0;  ///< Inverse covariance.
    float reach = 0;               ///< Largest squared distance, by that inverse, at which it is not fainter than least_alpha.
    float opacity = 0;
    float depth = 0, per_x = 0, per_y = 0;  ///< Meters at the center, and per pixel.
    Vec3f color{};
    float left = 0, right = -1, top = 0, bottom = -1;  ///< Its box; empty if nothing of it is in the picture.
};

/// The Gaussian's covariance in the camera's axes, and its center there.
struct InCamera
{
    Vec3d center;
    std::array<Vec3d, 3> axes;  ///< The rows of a matrix whose product with its transpose is the covariance.
};

InCamera in_camera(const Splats& splats, std::size_t i, const RigidTransform& camera_from_world)
{
    const auto axes = axes_of(splats, i);
    const Vec3f scale = splats.scales[i];
    const Mat3& turn = camera_from_world.rotation;
    const Vec3d a = turn * axes[0] * double{scale.x}, b = turn * axes[1] * double{scale.y}, c = turn * axes[2] * double{scale.z};
    return {camera_from_world.point(vec_cast<double>(splats.centers[i])), {{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}}}};
}

Footprint footprint(const InCamera& gaussian, float opacity, Vec3f color, const Intrinsics& lens)
{
    const auto& [center, axes] = gaussian;
    const auto slope = [&](double along, int side, double focal)
    { return std::clamp(along / center.z, -farthest_outside * side / (2 * focal), farthest_outside * side / (2 * focal)); };
    const Vec3d right = (axes[0] - axes[2] * slope(center.x, lens.width, lens.fx)) * (lens.fx / center.z);
    const Vec3d down = (axes[1] - axes[2] * slope(center.y, lens.height, lens.fy)) * (lens.fy / center.z);
    const double xx = dot(right, right) + pixel_variance, yy = dot(down, down) + pixel_variance, xy = dot(right, down);
    // The determinant of the covariance is written so that long Gaussians do not cancel it.
    const Vec3d area = cross(right, down);
    const double inverse = 1 / (dot(area, area) + pixel_variance * (xx + yy - pixel_variance));
    const double zx = dot(axes[2], right), zy = dot(axes[2], down);
    const double reach = 2 * std::log(opacity / static_cast<double>(least_alpha));
    const double x = lens.fx * center.x / center.z + lens.cx, y = lens.fy * center.y / center.z + lens.cy;
    const double half_width = std::sqrt(reach * xx), half_height = std::sqrt(reach * yy);
    const auto narrow = [](double value) { return static_cast<float>(value); };
    Footprint found{narrow(x),     narrow(y), narrow(yy * inverse), narrow(-xy * inverse), narrow(xx * inverse),
                    narrow(reach), opacity};
    found.depth = narrow(center.z);
    found.per_x = narrow((zx * yy - zy * xy) * inverse);
    found.per_y = narrow((zy * xx - zx * xy) * inverse);
    found.color = color;
    if (x + half_width > 0 && x - half_width < lens.width && y + half_height > 0 && y - half_height < lens.height)
    {
        found.left = narrow(std::max(x - half_width, 0.0));
        found.right = narrow(std::min(x + half_width, lens.width - 1.0));
        found.top = narrow(std::max(y - half_height, 0.0));
        found.bottom = narrow(std::min(y + half_height, lens.height - 1.0));
    }
    return found;
}

/// The footprints in the picture, nearest first.
std::vector<Footprint> footprints(const Splats& splats, const Camera& camera, double nearest_m, const Progress& progress)
{
    const RigidTransform camera_from_world = camera.world_from_camera.inverse();
    std::vector<Footprint> all(splats.size());
    parallel_items(all.size(), projected_at_once, progress,
                   [&](std::size_t i)
                   {
                       if (!(splats.opacities[i] > least_alpha))
                           return;
                       const InCamera gaussian = in_camera(splats, i, camera_from_world);
                       if (gaussian.center.z > nearest_m)
                           all[i] = footprint(gaussian, splats.opacities[i], splats.colors[i], camera.intrinsics);
                   });
    std::vector<std::uint64_t> order;
    std::uint32_t largest = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].right >= all[i].left && all[i].bottom >= all[i].top)
        {
            const std::uint32_t key = numerics::ordered_key(all[i].depth);
            largest = std::max(largest, key);
            order.push_back(std::uint64_t{key} << 32U | i);
        }
    numerics::sort_by_upper_half(order, largest);
    std::vector<Footprint> sorted;
    sorted.reserve(order.size());
    for (const std::uint64_t entry : order)
        sorted.push_back(all[entry & 0xffffffffU]);
    return sorted;
}

/// e^x for x from -87 to 0, to 2e-7 of it.
Quad exponential(Quad x)
{
    const Quad scaled = x * 1.44269504F;
    const Mask whole = __builtin_convertvector(scaled - 0.5F, Mask);
    const Quad rest = (scaled - __builtin_convertvector(whole, Quad)) * 0.693147181F;
    Quad sum = rest * (1.0F / 720) + 1.0F / 120;
    sum = sum * rest + 1.0F / 24;
    sum = sum * rest + 1.0F / 6;
    sum = sum * rest + 0.5F;
    sum = sum * rest + 1.0F;
    sum = sum * rest + 1.0F;
    const Mask bits = (whole + 127) << 23;
    return sum * std::bit_cast<Quad>(bits);
}

/// Pixels of a tile, row by row.
class Tile
{
  public:
    Tile(int left, int top) : left_(left), top_(top)
    {
        for (Quad& through : through_)
            through = Quad{} + 1.0F;
    }

    void draw(const Footprint& gaussian)
    {
        const int first = std::max(static_cast<int>(gaussian.top) - top_, 0);
        const int last = std::min(static_cast<int>(gaussian.bottom) - top_, tile - 1);
        const float determinant = gaussian.xx * gaussian.yy - gaussian.xy * gaussian.xy;
        for (int row = first; row <= last; ++row)
        {
            const float dy = static_cast<float>(top_ + row) + 0.5F - gaussian.y;
            const float left_over = gaussian.reach * gaussian.xx - determinant * dy * dy;
            // A pixel more on both sides makes up for rounding.
            const float half = std::sqrt(std::max(left_over, 0.0F)) / gaussian.xx + 1;
            const float middle = gaussian.x - gaussian.xy * dy / gaussian.xx - 0.5F - static_cast<float>(left_);
            // Beside the tile, or not a number: footprints may be larger than float.
            if (!(left_over >= 0 && middle + half >= 0 && middle - half < tile))
                continue;
            const int begin = static_cast<int>(std::max(middle - half, 0.0F)) / quad;
            const int end = static_cast<int>(std::min(middle + half, tile - 1.0F)) / quad + 1;
            for (int i = begin; i < end; ++i)
                blend(gaussian, i, row, dy);
        }
    }

    bool is_opaque() const
    {
        Quad most{};
        for (const Quad through : through_)
            most = through > most ? through : most;
        return std::max(std::max(most[0], most[1]), std::max(most[2], most[3])) < opaque;
    }

    void write(SplatPicture& picture) const
    {
        const int width = std::min(tile, picture.depth.width - left_);
        const int height = std::min(tile, picture.depth.height - top_);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
            {
                const auto at = static_cast<std::size_t>(y * (tile / quad) + x / quad);
                const int lane = x % quad;
                const std::size_t pixel = picture.depth.index(left_ + x, top_ + y);
                picture.transmittance.values[pixel] = through_[at][lane];
                picture.depth.values[pixel] = depth_[at][lane];
                for (std::size_t c = 0; c < 3; ++c)
                    picture.color.values[3 * pixel + c] = color_[c][at][lane];
            }
    }

  private:
    static constexpr std::size_t quads = std::size_t{tile} * tile / quad;

    void blend(const Footprint& gaussian, int column, int row, float dy)
    {
        const auto at = static_cast<std::size_t>(row * (tile / quad) + column);
        const Quad dx = Quad{0, 1, 2, 3} + (static_cast<float>(left_ + column * quad) + 0.5F - gaussian.x);
        const Quad squared = gaussian.xx * dx * dx + 2 * gaussian.xy * dy * dx + gaussian.yy * dy * dy;
        const Quad near = squared > 0.0F ? squared : Quad{};  // Rounding may leave it below.
        Quad alpha = gaussian.opacity * exponential((near < 80.0F ? near : Quad{} + 80.0F) * -0.5F);
        alpha = alpha < most_alpha ? alpha : Quad{} + most_alpha;
        alpha = alpha >= least_alpha ? alpha : Quad{};
        const Quad before = through_[at];
        const Quad after = before - before * alpha;
        const Quad share = before * alpha;
        for (std::size_t c = 0; c < 3; ++c)
            color_[c][at] += share * (c == 0 ? gaussian.color.x : c == 1 ? gaussian.color.y : gaussian.color.z);
        depth_[at] = (before >= 0.5F) & (after < 0.5F) ? gaussian.depth + gaussian.per_x * dx + gaussian.per_y * dy : depth_[at];
        through_[at] = after;
    }

    int left_, top_;
    std::array<Quad, quads> through_{}, depth_{};
    std::array<std::array<Quad, quads>, 3> color_{};
};

}  // namespace

SplatPicture render_splats(const Splats& splats, const Camera& camera, double nearest_m, const Progress& progress)
{
    const int width = camera.intrinsics.width, height = camera.intrinsics.height;
    const std::vector<Footprint> drawn = footprints(splats, camera, nearest_m, progress);
    const int across = (width + tile - 1) / tile, down = (height + tile - 1) / tile;
    // By rows of tiles, as each tile of its own would take gigabytes for many large Gaussians.
    const numerics::Buckets of_row(static_cast<std::size_t>(down),
                                   [&](const auto& add)
                                   {
                                       for (std::uint32_t i = 0; i < drawn.size(); ++i)
                                           for (int y = static_cast<int>(drawn[i].top) / tile;
                                                y <= static_cast<int>(drawn[i].bottom) / tile; ++y)
                                               add(static_cast<std::size_t>(y), i);
                                   });
    SplatPicture picture{RasterF(width, height, 3), RasterF(width, height), RasterF(width, height)};
    parallel_items(across * down, 4, progress,
                   [&](int number)
                   {
                       const int left = number % across * tile, row = number / across;
                       Tile pixels(left, row * tile);
                       std::size_t count = 0;
                       for (const std::uint32_t i : of_row[static_cast<std::size_t>(row)])
                       {
                           if (drawn[i].right < static_cast<float>(left) || drawn[i].left >= static_cast<float>(left + tile))
                               continue;
                           if (count++ % drawn_at_once == 0 && pixels.is_opaque())
                               break;
                           pixels.draw(drawn[i]);
                       }
                       pixels.write(picture);
                   });
    return picture;
}

}  // namespace fresco::splats
