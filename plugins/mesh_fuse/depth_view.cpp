#include "depth_view.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

using namespace fresco;

namespace fuse
{
namespace
{

/// A fit takes 5 x 5 pixels, one in so many: an angle of 0.8 degrees.
constexpr int window = 2;
constexpr double focal_per_step_px = 300;
constexpr double longest_step = 8;
constexpr int fewest_fitted = 6;
constexpr int fewest_continuing = 6;
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

    /// Least squares over the pixels of the window that may lie on the same surface.
    Fit fit(int x, int y) const
    {
        const float here = inverse_.at(x, y);
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

    bool is_continued(int x, int y, const Fit& fit) const
    {
        if (x == 0 || y == 0 || x + 1 == inverse_.width || y + 1 == inverse_.height)
            return false;
        const float here = fit.here;
        const float near = tolerance(here);
        int count = 0;
        for (int v = -1; v <= 1; ++v)
            for (int u = -1; u <= 1; ++u)
            {
                const float there = inverse_.at(x + u, y + v);
                const float expected = here + static_cast<float>(u) * fit.x + static_cast<float>(v) * fit.y;
                count += there > 0 && std::abs(there - expected) <= near ? 1 : 0;
            }
        return count > fewest_continuing;  // With itself.
    }

  private:
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
            const float inverse = fitter.inverse(x, y);
            const Fit fit = inverse > 0 ? fitter.fit(x, y) : Fit{};
            if (!fit.found || !fitter.is_continued(x, y, fit))
                continue;
            // 1/z = plane · ray for all points of the plane, whose rays have the length 1 along the axis.
            const Vec3f ray{static_cast<float>((x + 0.5 - k.cx) / k.fx), static_cast<float>((y + 0.5 - k.cy) / k.fy), 1};
            Vec3f plane{fit.x * static_cast<float>(k.fx), fit.y * static_cast<float>(k.fy), 0};
            plane.z = fit.here - dot(plane, ray);
            const float norm = length(plane);
            const float cosine = fit.here / (norm * length(ray));
            if (!(cosine >= least_cosine))
                continue;
            view.depth.at(x, y) = depth.at(x, y);
            view.planes.at(x, y) = {plane * (-1 / norm), 1 / norm, cosine * inverse * inverse};
        }
    return view;
}

}  // namespace fuse
