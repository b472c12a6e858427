#include "painting.h"

#include <fresco/error.h>
#include <fresco/geometry/surface_search.h>
#include <fresco/geometry/topology.h>
#include <fresco/rendering/mip_maps.h>
#include <fresco/texturing/face_frame.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

using namespace fresco;

namespace export_splats
{
namespace
{

using Part = splats::PaintedSplats::Part;

/// The width of a Gaussian, twice its standard deviation, is at most a quarter of a stroke where it is split.
constexpr double strokes_across = 0.25;
constexpr double largest_ratio = 16;        ///< Parts of larger Gaussians are larger: a few of these would make millions.
constexpr double least_opacity = 1 / 64.0;  ///< Parts that show less are left out.

/// Equal parts of a Gaussian along an axis, whose sum is the Gaussian.
struct Slices
{
    double scale = 0;                               ///< Standard deviation of each.
    double gain = 1;                                ///< Share of the Gaussian's density in each, before its weight.
    std::vector<std::pair<double, double>> places;  ///< Distance from the center, and weight.
};

/// A Gaussian is a narrower one, blurred: the weights are a Gaussian of the remaining variance. Samples two standard deviations
/// of the narrower one apart leave a ripple of 3 %.
Slices slices_of(double sigma, double limit)
{
    if (sigma <= limit)
        return {sigma, 1, {{0, 1}}};
    Slices slices;
    slices.scale = std::min(std::max(limit, sigma / largest_ratio), sigma * std::sqrt(0.5));
    const double rest = std::sqrt(sigma * sigma - slices.scale * slices.scale);
    constexpr double spacing = 2;
    constexpr double reach = 2.2;
    double sum = 0;
    for (double at = spacing * slices.scale / 2; at < reach * rest; at += spacing * slices.scale)
        for (const double place : {-at, at})
        {
            slices.places.emplace_back(place, std::exp(-place * place / (2 * rest * rest)));
            sum += slices.places.back().second;
        }
    slices.gain = sigma / slices.scale / sum;
    return slices;
}

class Painter
{
  public:
    Painter(const splats::Splats& splats, const TexturedMesh& textured, const PaintOptions& options)
        : splats_(splats), mesh_(textured.mesh), options_(options), search_(textured.mesh),
          texture_(textured.image.pixels, rendering::TextureFilter::trilinear)
    {
    }

    /// The parts of a Gaussian, which are one if it isn't split.
    void add(std::uint32_t i, std::vector<Part>& parts) const
    {
        const Vec3f scale = splats_.scales[i];
        std::array<double, 3> sigmas{double{scale.x}, double{scale.y}, double{scale.z}};
        const Vec3d center = vec_cast<double>(splats_.centers[i]);
        const auto axes = splats::axes_of(splats_, i);
        const auto nearest = search_.nearest(in_mesh(center));
        const double deviations =
            deviations_off(center, {axes[0] * sigmas[0], axes[1] * sigmas[1], axes[2] * sigmas[2]}, nearest);
        if (deviations > 3)
        {
            parts.push_back({.source = i, .keeps_color = true, .center = {}, .scale = {}, .color = {}});
            return;
        }
        // Colors do not change along the normal: of the three axes, the one that is nearest to it stays whole.
        const Vec3d normal = geometry::area_vector(mesh_, nearest.face);
        std::size_t across = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (std::abs(dot(axes[k], normal)) > std::abs(dot(axes[across], normal)))
                across = k;
        const std::size_t a = (across + 1) % 3;
        const std::size_t b = (across + 2) % 3;
        const std::size_t begin = parts.size();
        const Part whole{
            .source = i, .center = {}, .scale = {}, .color = color(center, axes[a] * sigmas[a], axes[b] * sigmas[b])};
        const double limit = options_.stroke_m * strokes_across / 2 / options_.unit_m;
        // A Gaussian that hardly lies on the surface shows no strokes.
        if (options_.densify && splats_.opacities[i] > 0 && deviations <= 1 && std::max(sigmas[a], sigmas[b]) > limit)
        {
            const Slices along_a = slices_of(sigmas[a], limit);
            const Slices along_b = slices_of(sigmas[b], limit);
            sigmas[a] = along_a.scale;
            sigmas[b] = along_b.scale;
            const Vec3f part_scale = vec_cast<float>(Vec3d{sigmas[0], sigmas[1], sigmas[2]});
            const double opacity = std::min(double{splats_.opacities[i]}, 0.999);
            for (const auto& [at_a, weight_a] : along_a.places)
                for (const auto& [at_b, weight_b] : along_b.places)
                {
                    // The logarithms of the shares of light that overlapping parts let through add up. Those of an opaque part
                    // fall off faster than its density; the factor keeps the sum over its footprint.
                    const double depth = -std::log1p(-opacity * weight_a * weight_b) * along_a.gain * along_b.gain;
                    const double shown = -std::expm1(-depth * (1 + 0.4 * depth));
                    if (shown < least_opacity)
                        continue;
                    const Vec3d place = center + axes[a] * at_a + axes[b] * at_b;
                    parts.push_back({.source = i,
                                     .is_split = true,
                                     .center = vec_cast<float>(place),
                                     .scale = part_scale,
                                     .opacity = static_cast<float>(shown),
                                     .color = color(place, axes[a] * sigmas[a], axes[b] * sigmas[b])});
                }
        }
        if (parts.size() == begin)
            parts.push_back(whole);
    }

  private:
    Vec3d in_mesh(Vec3d p) const { return p * options_.unit_m - mesh_.offset_m; }

    /// How far a Gaussian with these axes is from the surface, in its standard deviations, less a stroke, by which a mesh that
    /// was fused from pictures may be off.
    double deviations_off(Vec3d center, const std::array<Vec3d, 3>& axes, const geometry::SurfacePoint& nearest) const
    {
        const double distance = std::sqrt(nearest.squared_distance);
        if (distance <= options_.stroke_m)
            return 0;
        Vec3d way = -in_mesh(center);
        for (std::size_t k = 0; k < 3; ++k)
            way += vec_cast<double>(mesh_.positions[mesh_.triangles[nearest.face][k]]) * nearest.weights[k];
        Vec3d along;
        for (std::size_t k = 0; k < 3; ++k)
            along += axes[k] * dot(axes[k], way);
        return (distance - options_.stroke_m) * distance / (options_.unit_m * std::sqrt(dot(along, way)));
    }

    /// The mean color of the surface around a point of the splat, over one standard deviation along two axes, or over its
    /// distance if that is more: what hangs over a hole would show single texels of the border as streaks.
    Vec3f color(Vec3d center, Vec3d a, Vec3d b) const
    {
        const geometry::SurfacePoint nearest = search_.nearest(in_mesh(center));
        const double off = (std::sqrt(nearest.squared_distance) - options_.stroke_m) / options_.unit_m;
        const double size = std::max(length(a), length(b)), wider = std::max(1.0, off / size);
        // Smaller copies of the picture mix charts that only lie side by side there: a larger footprint is looked up in parts.
        constexpr double largest_lod = 2;
        const double wanted = lod(nearest.face, options_.unit_m * size * wider);
        if (wanted <= largest_lod)
            return vec_cast<float>(sample(nearest, wanted));
        constexpr int side = 2;
        constexpr double step = 0.9;
        Vec3d sum;
        double weights = 0;
        for (int i = -side; i <= side; ++i)
            for (int j = -side; j <= side; ++j)
            {
                const double weight = std::exp(-(i * i + j * j) * step * step / 2);
                sum += sample(search_.nearest(in_mesh(center + (a * i + b * j) * (step * wider))), largest_lod) * weight;
                weights += weight;
            }
        return vec_cast<float>(sum * (1 / weights));
    }

    /// The size of the picture's copy whose texels have this width on a face.
    double lod(std::uint32_t face, double width_m) const
    {
        const double area = length(geometry::area_vector(mesh_, face));
        const double uv_area = std::abs(texturing::FaceFrame(mesh_, face, 1).area);
        const double texels = uv_area * texture_.width() * texture_.height();
        return area > 0 && texels > 0 ? std::max(0.0, std::log2(width_m * std::sqrt(texels / area))) : 0;
    }

    Vec3d sample(const geometry::SurfacePoint& point, double level) const
    {
        Vec2d uv;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const Vec2f corner = mesh_.texcoords[3 * std::size_t{point.face} + k];
            uv = uv + Vec2d{corner.x, corner.y} * point.weights[k];
        }
        return texture_.sample(uv, level) * (1 / 255.0);
    }

    const splats::Splats& splats_;
    const Mesh& mesh_;
    PaintOptions options_;
    geometry::SurfaceSearch search_;
    rendering::MipMaps texture_;
};

}  // namespace

Painting paint(const splats::Splats& splats, const TexturedMesh& textured, const PaintOptions& options, const Progress& progress)
{
    const Painter painter(splats, textured, options);
    constexpr std::size_t grain = 2048;
    std::vector<std::vector<Part>> pieces((splats.size() + grain - 1) / grain);
    std::atomic<std::size_t> made = 0;
    parallel_for(splats.size(), grain, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     auto& parts = pieces[begin / grain];
                     for (std::size_t i = begin; i < end; ++i)
                     {
                         progress.check_canceled();
                         const std::size_t before = parts.size();
                         painter.add(static_cast<std::uint32_t>(i), parts);
                         made += parts.size() - before;
                         if (options.densify && made > options.most_parts)
                             throw Error(
                                 fmt::format("splitting Gaussians that are larger than a quarter of a stroke of {:.3g} cm "
                                             "would make more than {} of them: use a larger stroke_cm, check that "
                                             "unit_m is right, or set densify: false",
                                             100 * options.stroke_m, options.most_parts));
                     }
                 });
    Painting painting;
    painting.splats.parts.reserve(made);
    for (auto& parts : pieces)
    {
        for (const Part& part : parts)
        {
            const auto& all = painting.splats.parts;
            painting.split += part.is_split && (all.empty() || all.back().source != part.source) ? 1 : 0;
            painting.unpainted += part.keeps_color ? 1 : 0;
            painting.splats.parts.push_back(part);
        }
        parts = std::vector<Part>();  // All parts twice may not fit; `= {}` would keep the memory.
    }
    return painting;
}

void turn_over(splats::Splats& splats, splats::PaintedSplats& painted)
{
    const auto turn = [](Vec3f& p) { p = {p.x, -p.y, -p.z}; };
    for (Vec3f& center : splats.centers)
        turn(center);
    for (auto& q : splats.rotations)
        q = {-q[1], q[0], -q[3], q[2]};
    for (Part& part : painted.parts)
        turn(part.center);
}

}  // namespace export_splats
