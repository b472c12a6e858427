#include "integration.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <utility>

using namespace fresco;

namespace fuse
{

Volume::Volume(double voxel_m, std::vector<BlockPlace> places)
    : voxel_m_(voxel_m), places_(std::move(places)), blocks_(places_.size())
{
}

std::size_t Volume::find(BlockPlace place) const
{
    const auto found = std::ranges::lower_bound(places_, place);
    return found == places_.end() || *found != place ? none : static_cast<std::size_t>(found - places_.begin());
}

fresco::Vec3d Volume::origin(std::size_t block) const
{
    const BlockPlace& place = places_[block];
    const double side = block_side * voxel_m_;
    return {place.x * side, place.y * side, place.z * side};
}

namespace
{

/// A fit takes 5 x 5 pixels, one in so many: an angle of 0.8 degrees.
constexpr int window = 2;
constexpr double focal_per_step_px = 300;
constexpr double longest_step = 8;
constexpr int fewest_fitted = 6;
/// Minimum number of a pixel's eight neighbors that continue its plane; or, beside holes and in them, that it reaches closely,
/// some of them across a hole of a pixel.
constexpr int fewest_continuing = 6;
constexpr int fewest_reached = 5;
constexpr int fewest_close = 3;
constexpr float close_share = 0.5F;
constexpr int fewest_around_hole = 4;
/// Factor of the weight beside a hole.
constexpr float beside_hole = 0.25F;
constexpr float least_cosine = 0.2F;

/// A fit takes what may lie on a surface that leans by so much: meters of depth per meter across.
constexpr float steepest_fitted = 2;

/// How far inverse depths may lie from a plane that they belong to, 1/m: 1.5 % of the distance, and twice the step of a Kinect.
float tolerance(float inverse)
{
    return 0.015F * inverse + 0.006F;
}

/// A plane in the inverse depth: at the pixel, and its change per pixel.
struct Fit
{
    float here = 0;
    float x = 0;
    float y = 0;
    bool found = false;
};

class Fitter
{
  public:
    Fitter(const RasterF& depth, double max_depth_m, double focal_px)
        : inverse_(depth.width, depth.height), focal_px_(static_cast<float>(focal_px)),
          step_px_(static_cast<int>(std::lround(std::clamp(focal_px / focal_per_step_px, 1.0, longest_step))))
    {
        for (std::size_t i = 0; i < depth.values.size(); ++i)
            if (depth.values[i] > 0 && double{depth.values[i]} <= max_depth_m)
                inverse_.values[i] = 1 / depth.values[i];
    }

    float inverse(int x, int y) const { return inverse_.at(x, y); }

    /// The inverse depth that a pixel without one would have among its neighbors: their median; 0 if they are too few.
    float bridged(int x, int y) const
    {
        std::array<float, 8> around{};
        std::size_t count = 0;
        for (int v = std::max(0, y - 1); v <= std::min(inverse_.height - 1, y + 1); ++v)
            for (int u = std::max(0, x - 1); u <= std::min(inverse_.width - 1, x + 1); ++u)
                if (inverse_.at(u, v) > 0)
                    around[count++] = inverse_.at(u, v);
        if (count < fewest_around_hole)
            return 0;
        std::nth_element(around.begin(), around.begin() + count / 2, around.begin() + count);
        return around[count / 2];
    }

    /// Least squares over the pixels of the window that may lie on the same surface as one of inverse depth `here`.
    Fit fit(int x, int y, float here) const
    {
        const float near = tolerance(here);
        const float per_pixel = steepest_fitted * here / focal_px_;
        int count = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0, sum_yy = 0;
        float sum = 0, sum_xd = 0, sum_yd = 0;
        for (int v = -window * step_px_; v <= window * step_px_; v += step_px_)
        {
            if (y + v < 0 || y + v >= inverse_.height)
                continue;
            for (int u = -window * step_px_; u <= window * step_px_; u += step_px_)
            {
                if (x + u < 0 || x + u >= inverse_.width)
                    continue;
                const float there = inverse_.at(x + u, y + v);
                const float difference = there - here;
                if (there <= 0 ||
                    std::abs(difference) > near + per_pixel * static_cast<float>(std::max(std::abs(u), std::abs(v))))
                    continue;
                ++count;
                sum_x += u;
                sum_y += v;
                sum_xx += u * u;
                sum_xy += u * v;
                sum_yy += v * v;
                sum += difference;
                sum_xd += static_cast<float>(u) * difference;
                sum_yd += static_cast<float>(v) * difference;
            }
        }
        const auto xx = static_cast<float>(count * sum_xx - sum_x * sum_x);
        const auto xy = static_cast<float>(count * sum_xy - sum_x * sum_y);
        const auto yy = static_cast<float>(count * sum_yy - sum_y * sum_y);
        const float determinant = xx * yy - xy * xy;
        if (count < fewest_fitted || !(determinant > 0))
            return {};
        const float xd = static_cast<float>(count) * sum_xd - static_cast<float>(sum_x) * sum;
        const float yd = static_cast<float>(count) * sum_yd - static_cast<float>(sum_y) * sum;
        const float slope_x = (xd * yy - yd * xy) / determinant, slope_y = (yd * xx - xd * xy) / determinant;
        const float shift =
            (sum - slope_x * static_cast<float>(sum_x) - slope_y * static_cast<float>(sum_y)) / static_cast<float>(count);
        return {here + shift, slope_x, slope_y, true};
    }

    /// How far a pixel's neighbors bear out its plane: 1, less beside holes of a pixel, 0 beside wider ones, other surfaces and
    /// the border.
    float trust(int x, int y, const Fit& fit) const
    {
        if (x == 0 || y == 0 || x + 1 == inverse_.width || y + 1 == inverse_.height)
            return 0;
        int continuing = 0, close = 0, across = 0, apart = 0;
        for (int v = -1; v <= 1; ++v)
            for (int u = -1; u <= 1; ++u)
            {
                if (u == 0 && v == 0)
                    continue;
                if (inverse_.at(x + u, y + v) > 0)
                {
                    ++(is_on(fit, x, y, u, v, 1) ? continuing : apart);
                    close += is_on(fit, x, y, u, v, close_share);
                }
                else if (x + 2 * u >= 0 && y + 2 * v >= 0 && x + 2 * u < inverse_.width && y + 2 * v < inverse_.height)
                    across += is_on(fit, x, y, 2 * u, 2 * v, close_share);
            }
        if (inverse_.at(x, y) > 0 && continuing >= fewest_continuing)
            return 1;
        if (apart > 0 || close + across < fewest_reached || close < fewest_close)
            return 0;
        return beside_hole * static_cast<float>(close * close) / 64;
    }

  private:
    /// Whether the pixel at (x + u, y + v) was measured on the plane that was fitted at (x, y), to a share of the tolerance.
    bool is_on(const Fit& fit, int x, int y, int u, int v, float share) const
    {
        const float there = inverse_.at(x + u, y + v);
        const float expected = fit.here + static_cast<float>(u) * fit.x + static_cast<float>(v) * fit.y;
        return there > 0 && std::abs(there - expected) <= share * tolerance(fit.here);
    }

    RasterF inverse_;  ///< 0: none.
    float focal_px_;
    int step_px_;
};

}  // namespace

DepthView depth_view(const RasterF& depth, const Camera& camera, double max_depth_m)
{
    const Fitter fitter(depth, max_depth_m, camera.intrinsics.fx);
    const Intrinsics& k = camera.intrinsics;
    DepthView view{camera, RasterF(depth.width, depth.height), Raster<PixelPlane>(depth.width, depth.height)};
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
        {
            const bool is_measured = fitter.inverse(x, y) > 0;
            const float inverse = is_measured ? fitter.inverse(x, y) : fitter.bridged(x, y);
            const Fit fit = inverse > 0 ? fitter.fit(x, y, inverse) : Fit{};
            const float trust = fit.found ? fitter.trust(x, y, fit) : 0;
            if (!(trust > 0))
                continue;
            // 1/z = plane · ray for all points of the plane, whose rays have the length 1 along the axis.
            const Vec3f ray{static_cast<float>((x + 0.5 - k.cx) / k.fx), static_cast<float>((y + 0.5 - k.cy) / k.fy), 1};
            Vec3f plane{fit.x * static_cast<float>(k.fx), fit.y * static_cast<float>(k.fy), 0};
            plane.z = fit.here - dot(plane, ray);
            const float norm = length(plane);
            const float cosine = fit.here / (norm * length(ray));
            if (!(cosine >= least_cosine))
                continue;
            view.depth.at(x, y) = is_measured ? depth.at(x, y) : 1 / fit.here;
            view.planes.at(x, y) = {plane * (-1 / norm), 1 / norm, trust * cosine * inverse * inverse};
        }
    return view;
}

namespace
{

/// A set that is sorted now and then.
class Places
{
  public:
    explicit Places(std::size_t most) : most_(most) {}

    /// False once there are more than the most.
    bool add(BlockPlace place)
    {
        places_.push_back(place);
        if (places_.size() < next_sort_)
            return true;
        sort();
        return places_.size() <= most_;
    }

    std::vector<BlockPlace> take()
    {
        sort();
        return std::move(places_);
    }

  private:
    void sort()
    {
        std::ranges::sort(places_);
        const auto rest = std::ranges::unique(places_);
        places_.erase(rest.begin(), rest.end());
        if (places_.size() > most_)
            places_.resize(most_ + 1);
        next_sort_ = 2 * places_.size() + 4096;
    }

    std::size_t most_;
    std::size_t next_sort_ = 4096;
    std::vector<BlockPlace> places_;
};

struct Box
{
    BlockPlace low, high;
    friend bool operator==(const Box&, const Box&) = default;
};

}  // namespace

std::vector<BlockPlace> OpenedBlocks::near(const DepthView& view) const
{
    const double side = block_side * voxel_m;
    const auto block = [&](Vec3d p, double shift)
    {
        const auto along = [&](double at) { return static_cast<int>(std::floor((at + shift) / side)); };
        return BlockPlace{along(p.x), along(p.y), along(p.z)};
    };
    Places places(most);
    const auto add_all = [&](const Box& box)
    {
        for (int x = box.low.x; x <= box.high.x; ++x)
            for (int y = box.low.y; y <= box.high.y; ++y)
                for (int z = box.low.z; z <= box.high.z; ++z)
                    if (!places.add({x, y, z}))
                        return false;
        return true;
    };
    Box last{{1, 1, 1}, {0, 0, 0}};
    for (int y = 0; y < view.depth.height; ++y)
        for (int x = 0; x < view.depth.width; ++x)
        {
            const float meters = view.depth.at(x, y);
            if (!(meters > 0))
                continue;
            const Vec3d point = view.camera.world_from_camera.translation + view.camera.ray(x + 0.5, y + 0.5) * double{meters};
            const Box box{block(point, -reach_m), block(point, reach_m)};
            if (box == last)
                continue;
            if (!add_all(box))
                return places.take();
            last = box;
        }
    return places.take();
}

void unite(std::vector<BlockPlace>& places, const std::vector<BlockPlace>& more)
{
    std::vector<BlockPlace> all;
    all.reserve(places.size() + more.size());
    std::ranges::set_union(places, more, std::back_inserter(all));
    places = std::move(all);
}

namespace
{

constexpr int tile_px = 16;
constexpr float nearest_m = 1e-3F;

/// A view, prepared for many blocks.
class Integrator
{
  public:
    Integrator(const DepthView& view, double voxel_m, double truncation_m)
        : view_(view), camera_from_world_(view.camera.world_from_camera.inverse()),
          fx_(static_cast<float>(view.camera.intrinsics.fx)), fy_(static_cast<float>(view.camera.intrinsics.fy)),
          cx_(static_cast<float>(view.camera.intrinsics.cx)), cy_(static_cast<float>(view.camera.intrinsics.cy)),
          voxel_(static_cast<float>(voxel_m)), truncation_(static_cast<float>(truncation_m)),
          farthest_((view.planes.width + tile_px - 1) / tile_px, (view.planes.height + tile_px - 1) / tile_px)
    {
        const auto step = [&](Vec3d axis) { return vec_cast<float>(camera_from_world_.direction(axis * voxel_m)); };
        step_x_ = step({1, 0, 0});
        step_y_ = step({0, 1, 0});
        step_z_ = step({0, 0, 1});
        find_farthest();
    }

    void add(Vec3d origin, Block& block) const
    {
        const Vec3f first = vec_cast<float>(camera_from_world_.point(origin));
        if (!may_see(first))
            return;
        for (int z = 0; z < block_side; ++z)
            for (int y = 0; y < block_side; ++y)
            {
                const Vec3f row = first + step_y_ * static_cast<float>(y) + step_z_ * static_cast<float>(z);
                for (int x = 0; x < block_side; ++x)
                    add(row + step_x_ * static_cast<float>(x), block[voxel_index(x, y, z)]);
            }
    }

  private:
    void add(Vec3f point, Voxel& voxel) const
    {
        if (!(point.z > nearest_m))
            return;
        const float scale = 1 / point.z;
        const float u = fx_ * point.x * scale + cx_;
        const float v = fy_ * point.y * scale + cy_;
        if (!(u >= 0 && v >= 0 && u < static_cast<float>(view_.planes.width) && v < static_cast<float>(view_.planes.height)))
            return;
        const PixelPlane& plane = view_.planes.at(static_cast<int>(u), static_cast<int>(v));
        const float distance = plane.distance(point);
        if (!(plane.weight > 0) || !(distance > -truncation_))
            return;
        const float share = distance >= -voxel_ ? 1.0F : (truncation_ + distance) / (truncation_ - voxel_);
        const float weight = plane.weight * share;
        voxel.distance_sum += weight * std::min(distance, truncation_);
        voxel.weight += weight;
    }

    /// For each tile the largest depth at which one of its pixels changes a voxel.
    void find_farthest()
    {
        for (int y = 0; y < view_.planes.height; ++y)
            for (int x = 0; x < view_.planes.width; ++x)
            {
                const PixelPlane& plane = view_.planes.at(x, y);
                if (!(plane.weight > 0))
                    continue;
                const Vec3f ray{(static_cast<float>(x) + 0.5F - cx_) / fx_, (static_cast<float>(y) + 0.5F - cy_) / fy_, 1};
                // The least of the pixel's rays.
                const float toward =
                    -dot(plane.normal, ray) - 0.5F * (std::abs(plane.normal.x) / fx_ + std::abs(plane.normal.y) / fy_);
                const float depth = toward > 0 ? (plane.offset + truncation_) / toward : std::numeric_limits<float>::infinity();
                float& farthest = farthest_.at(x / tile_px, y / tile_px);
                farthest = std::max(farthest, depth);
            }
    }

    /// Whether the view may change a voxel of the block whose first voxel is at `first` in the camera's frame.
    bool may_see(Vec3f first) const
    {
        constexpr float infinite = std::numeric_limits<float>::infinity();
        float low_u = infinite, low_v = infinite, high_u = -infinite, high_v = -infinite, low_z = infinite;
        bool some_behind = false;
        float high_z = -infinite;
        for (int corner = 0; corner < 8; ++corner)
        {
            const auto shift = [&](int bit) { return (corner >> bit & 1) != 0 ? static_cast<float>(block_side - 1) : 0.0F; };
            const Vec3f p = first + step_x_ * shift(0) + step_y_ * shift(1) + step_z_ * shift(2);
            low_z = std::min(low_z, p.z);
            high_z = std::max(high_z, p.z);
            some_behind = some_behind || !(p.z > nearest_m);
            const float scale = 1 / p.z;
            const float u = fx_ * p.x * scale + cx_;
            const float v = fy_ * p.y * scale + cy_;
            low_u = std::min(low_u, u);
            high_u = std::max(high_u, u);
            low_v = std::min(low_v, v);
            high_v = std::max(high_v, v);
        }
        if (some_behind)
            return high_z > nearest_m;
        // A pixel more, for what rounding does.
        const auto tile = [](float at, int count)
        { return static_cast<int>(std::clamp(std::floor(at / tile_px), 0.0F, static_cast<float>(count - 1))); };
        if (high_u < -1 || high_v < -1 || low_u > static_cast<float>(view_.planes.width) + 1 ||
            low_v > static_cast<float>(view_.planes.height) + 1)
            return false;
        for (int y = tile(low_v - 1, farthest_.height); y <= tile(high_v + 1, farthest_.height); ++y)
            for (int x = tile(low_u - 1, farthest_.width); x <= tile(high_u + 1, farthest_.width); ++x)
                if (low_z * 0.9999F < farthest_.at(x, y))
                    return true;
        return false;
    }

    const DepthView& view_;
    RigidTransform camera_from_world_;
    float fx_, fy_, cx_, cy_;
    float voxel_, truncation_;
    Vec3f step_x_, step_y_, step_z_;
    RasterF farthest_;
};

}  // namespace

void integrate(std::span<const DepthView> views, double truncation_m, const Progress& progress, Volume& volume)
{
    std::vector<Integrator> integrators;
    for (const DepthView& view : views)
        integrators.emplace_back(view, volume.voxel_m(), truncation_m);
    parallel_items(volume.places().size(), 64, progress,
                   [&](std::size_t i)
                   {
                       for (const Integrator& integrator : integrators)
                           integrator.add(volume.origin(i), volume.block(i));
                   });
}

}  // namespace fuse
