#include "diagnosis.h"

#include "wording.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fresco::inspect
{
namespace
{

constexpr double near_share = 0.03;
/// Fewer depths than this share agree by chance alone: wrong conventions reach 0.12, a focal length 20 % off 0.3.
constexpr double fair_share = 0.25;
/// Rays that meet something else differ by more than a poor sensor does.
constexpr double fair_median_error = 0.05;
/// Edges at a wrong outline are as strong as anywhere; a focal length 10 % off leaves 0.4.
constexpr double fair_response = 0.2;
/// A camera within a room sees fronts of faces nearly everywhere.
constexpr double fair_fronts = 0.5;
constexpr std::size_t fair_outline_points = 300;
/// A convention must explain so many times as much as the recorded one.
constexpr double clearly = 2;
/// Cameras are told to be off by more than their calibration may be.
constexpr double focal_tolerance = 0.04;
constexpr double shift_tolerance = 0.015;
constexpr double scale_tolerance = 0.07;
constexpr double clearly_smaller_loss = 0.75;
constexpr double clearly_stronger = 1.25;
constexpr std::size_t rough_stride = 4;
constexpr int grid_columns = 40;

class Judge
{
  public:
    Judge(const raycast::Scene& scene, std::vector<View>& views, const Progress& progress)
        : scene_(scene), views_(views), progress_(progress)
    {
        for (const View& view : views)
        {
            if (!view.depth.samples.empty())
                depths_.push_back(view.depth);
            result_.depths += view.depth.samples.size();
        }
    }

    Diagnosis judge()
    {
        judge_recorded();
        if (depths_.empty())
            find_convention_by_edges();
        else
        {
            find_convention_by_depth();
            judge_depth_camera();
            result_.explained = agreement(ratios(result_.convention, result_.depth_focal_scale), result_.depth_scale);
            if (!depth_fits())
                explain_nothing();
        }
        tell_convention(result_.convention, result_.depth_scale, mesh_extent(scene_.mesh()), result_.findings);
        judge_color_camera();
        tell_cameras(result_, one_camera(), result_.findings);
        judge_sides();
        judge_rest();
        return std::move(result_);
    }

  private:
    DepthRatios ratios(const Convention& convention, double focal_scale = 1, std::size_t stride = 1) const
    {
        return depth_ratios(scene_, depths_, convention, focal_scale, stride, progress_);
    }

    double response(const Convention& convention, const CameraChange& change, std::size_t& points)
    {
        points = 0;
        colors_.clear();
        for (View& view : views_)
        {
            if (view.color.edges.empty())
                continue;
            find_outline(scene_, convention, view.color, progress_);
            points += view.color.outline.size();
            colors_.push_back(view.color);
        }
        return edge_response(colors_, convention, change);
    }

    static Agreement agreement(const DepthRatios& found, double scale)
    {
        const auto samples = static_cast<double>(std::max<std::size_t>(1, found.ratios.size()));
        return {found.share(scale, near_share), static_cast<double>(found.seen) / samples, found.median_error(scale)};
    }

    bool depth_fits() const
    {
        const Agreement& explained = result_.explained;
        return depths_.empty() || (explained.depth_share >= fair_share && explained.depth_median_error <= fair_median_error);
    }

    /// Takes back what was assumed: it does not fit either.
    void explain_nothing()
    {
        result_.convention = {};
        result_.depth_scale = 1;
        result_.depth_focal_scale = 1;
        result_.depth_by_color_camera = false;
        result_.explained = result_.recorded;
    }

    void judge_recorded()
    {
        result_.recorded = agreement(ratios({}), 1);
        result_.recorded.edge_response = response({}, {}, result_.outline_points);
    }

    void find_convention_by_depth()
    {
        const DepthRatios recorded = ratios({}, 1, rough_stride);
        const double share = recorded.share(recorded.best_scale(), near_share);
        if (share < fair_share)
            try_conventions(std::max(fair_share, clearly * share));
        find_depth_scale();
    }

    /// Takes the convention that most depths agree with, if that is a share of more than `most`.
    void try_conventions(double most)
    {
        for (const Convention& candidate : candidate_conventions(true))
        {
            const DepthRatios found = ratios(candidate, 1, rough_stride);
            // The first candidate is the plainest; a later one must beat it.
            if (const double share = found.share(found.best_scale(), near_share); share > most)
            {
                most = share * 1.02;
                result_.convention = candidate;
            }
        }
    }

    void find_depth_scale()
    {
        const DepthRatios found = ratios(result_.convention);
        const double scale = found.best_scale();
        if (std::abs(std::log(scale)) > scale_tolerance && found.share(scale, near_share) >= fair_share &&
            found.share(scale, near_share) > 1.5 * found.share(1, near_share))
            result_.depth_scale = usual_scale(scale);
    }

    /// The share of the color cameras' pixels that see the front of a face.
    double fronts(const Convention& convention) const
    {
        const DepthRatios seen = look(convention, rough_stride);
        return seen.ratios.empty() ? 0 : static_cast<double>(seen.fronts) / static_cast<double>(seen.ratios.size());
    }

    void find_convention_by_edges()
    {
        const bool sees = fronts({}) >= fair_fronts;
        const double recorded = result_.recorded.edge_response;
        if (sees && recorded >= fair_response && result_.outline_points >= fair_outline_points)
            return;
        double most = sees ? std::max(fair_response, clearly * recorded) : fair_response;
        for (const Convention& candidate : candidate_conventions(false))
        {
            if (fronts(candidate) < fair_fronts)
                continue;
            std::size_t points = 0;
            const double found = response(candidate, {}, points);
            if (found > most && points >= fair_outline_points)
            {
                most = found;
                result_.convention = candidate;
            }
        }
    }

    void judge_depth_camera()
    {
        const double recorded = ratios(result_.convention).loss(result_.depth_scale);
        double best = recorded;
        const auto try_focal = [&](double scale)
        {
            const double loss = ratios(result_.convention, scale, rough_stride).loss(result_.depth_scale);
            if (loss < best)
            {
                best = loss;
                result_.depth_focal_scale = scale;
            }
        };
        best = ratios(result_.convention, 1, rough_stride).loss(result_.depth_scale);
        constexpr int steps = 12;
        for (int step = -steps; step <= steps; ++step)
            try_focal(std::exp(depth_focal_reach * step / steps));
        const double middle = result_.depth_focal_scale;
        for (int step = -4; step <= 4; ++step)
            try_focal(middle * std::exp(0.005 * step));
        best = ratios(result_.convention, result_.depth_focal_scale).loss(result_.depth_scale);
        if (std::abs(std::log(result_.depth_focal_scale)) < focal_tolerance || best > clearly_smaller_loss * recorded)
        {
            result_.depth_focal_scale = 1;
            best = recorded;
        }
        if (one_camera())
            return;
        auto taken = depths_;
        std::size_t i = 0;
        for (const View& view : views_)
            if (!view.depth.samples.empty())
                taken[i++].camera = color_camera_for_depth(view);
        std::swap(taken, depths_);
        const double by_color = ratios(result_.convention).loss(result_.depth_scale);
        if (by_color < clearly_smaller_loss * recorded && by_color < 1.05 * best)
        {
            result_.depth_by_color_camera = true;
            result_.depth_focal_scale = 1;
        }
        else
            std::swap(taken, depths_);
    }

    static Camera color_camera_for_depth(const View& view)
    {
        const Intrinsics& size = view.depth.camera.intrinsics;
        return {view.color.camera.intrinsics.scaled_to(size.width, size.height), view.color.camera.world_from_camera};
    }

    /// Whether both cameras were given the same angles of view and poses.
    bool one_camera() const
    {
        return std::ranges::all_of(views_,
                                   [](const View& view)
                                   {
                                       const Camera color = color_camera_for_depth(view);
                                       const Camera& depth = view.depth.camera;
                                       return std::abs(color.intrinsics.fx / depth.intrinsics.fx - 1) < 0.002 &&
                                              std::abs(color.intrinsics.fy / depth.intrinsics.fy - 1) < 0.002 &&
                                              color.world_from_camera == depth.world_from_camera;
                                   });
    }

    void judge_color_camera()
    {
        std::size_t points = 0;
        const double recorded = response(result_.convention, {}, points);
        result_.explained.edge_response = recorded;
        // Where mesh and poses are apart, a wrong camera fits the edges better than the right one.
        if (points < fair_outline_points || !(depth_fits() && result_.explained.depth_clear()))
            return;
        const CameraChange change = best_change(colors_, result_.convention, progress_);
        if (std::abs(std::log(change.focal_scale)) < focal_tolerance && std::abs(change.shift_x) < shift_tolerance &&
            std::abs(change.shift_y) < shift_tolerance)
            return;
        const auto [before, after] = compare_responses(colors_, result_.convention, change);
        if (after > fair_response && after > clearly_stronger * before)
        {
            result_.color_change = change;
            result_.explained.edge_response = after;
        }
    }

    /// What the color cameras see on a grid over their pictures; distances stand in for ratios.
    DepthRatios look(const Convention& convention, std::size_t stride) const
    {
        std::vector<SampledDepth> looks;
        for (const View& view : views_)
        {
            const Intrinsics& k = view.color.camera.intrinsics;
            looks.push_back({view.color.camera, sample_depth(RasterF(k.width, k.height, 1, 1.0F), grid_columns)});
        }
        return depth_ratios(scene_, looks, convention, 1, stride, progress_);
    }

    void judge_sides()
    {
        const DepthRatios seen = look(result_.convention, 1);
        if (seen.ratios.empty() || seen.seen == 0)
            return;
        result_.seen_share = static_cast<double>(seen.seen) / static_cast<double>(seen.ratios.size());
        result_.front_share = static_cast<double>(seen.fronts) / static_cast<double>(seen.seen);
        if (result_.front_share < 0.2 && depth_fits())
            tell_inside_out(result_.front_share, result_.findings);
    }

    void judge_rest()
    {
        const bool edges_fit =
            result_.outline_points < fair_outline_points || result_.explained.edge_response >= fair_response / 2;
        if (!depth_fits())
            tell_unexplained_depth(result_, result_.findings);
        else if (!edges_fit || result_.seen_share == 0)
            tell_unexplained_edges(result_, result_.findings);
    }

    const raycast::Scene& scene_;
    std::vector<View>& views_;
    const Progress& progress_;
    std::vector<SampledDepth> depths_;
    std::vector<OutlinedFrame> colors_;
    Diagnosis result_;
};

}  // namespace

std::pair<Camera, Camera> explained_cameras(const Diagnosis& diagnosis, const Camera& color, const Camera& depth)
{
    Camera new_depth = depth;
    if (diagnosis.depth_by_color_camera)
        new_depth = {color.intrinsics.scaled_to(depth.intrinsics.width, depth.intrinsics.height), color.world_from_camera};
    new_depth.intrinsics.fx *= diagnosis.depth_focal_scale;
    new_depth.intrinsics.fy *= diagnosis.depth_focal_scale;
    Camera new_color{changed(color.intrinsics, diagnosis.color_change), color.world_from_camera};
    for (Camera* camera : {&new_color, &new_depth})
        camera->world_from_camera = diagnosis.convention.correct(camera->world_from_camera);
    return {new_color, new_depth};
}

Diagnosis diagnose(const raycast::Scene& scene, std::vector<View>& views, const Progress& progress)
{
    return Judge(scene, views, progress).judge();
}

}  // namespace fresco::inspect
