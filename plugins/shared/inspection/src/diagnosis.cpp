#include <fresco/inspection/diagnosis.h>

#include "explain_depths.h"

#include <fresco/camera.h>
#include <fresco/inspection/wording.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace fresco::inspect
{
namespace
{

/// The hit of the ray through a pixel of a camera.
raycast::Hit seen_at(const raycast::Scene& scene, const Camera& camera, Vec2f pixel)
{
    const std::array direction{camera.ray(static_cast<double>(pixel.x), static_cast<double>(pixel.y))};
    std::array<raycast::Hit, 1> hit;
    scene.cast(camera.world_from_camera.translation, direction, hit);
    return hit[0];
}

/// Edges at a wrong outline are as strong as anywhere.
constexpr double fair_response = 0.15;
/// Another assumption must be so many times as good as the recorded one.
constexpr double clearly = 1.6;
constexpr double no_response = 0.04;
constexpr std::size_t fair_outline_points = 300;
constexpr int color_focal_steps = 15;
constexpr double contradicting = 0.25;
constexpr double hardly_covered = 0.002;
constexpr std::size_t look_stride = 4;
/// Half of what a depth camera sees of a room is nearer than the one and farther than the other.
constexpr double largest_depth_m = 6;
constexpr double least_depth_m = 0.5;
/// Parts that agree less than this do not belong together.
constexpr double hopeless = 0.2;
/// Moving people, mixed pixels and noise of a few percent stay below this share.
constexpr double clearly_seen_through = 0.05;

RigidTransform color_pose(const View& view, const Assumption& assumption)
{
    return assumption.pose(view.depth.pose) * view.depth.depth_from_color;
}

class Judge
{
  public:
    Judge(const raycast::Scene* scene, const std::vector<View>& views, const Progress& progress)
        : scene_(scene), views_(views), progress_(progress)
    {
        for (const View& view : views)
            if (!view.depth.samples.empty())
            {
                depths_.push_back(view.depth);
                result_.depths += view.depth.samples.size();
            }
    }

    Diagnosis judge()
    {
        if (!depths_.empty())
            result_.assumption = explain_depths(scene_, depths_, progress_);
        if (scene_ == nullptr)
            choose_unit();
        result_.recorded = fit({});
        result_.outline_points = points_of(edge_views(result_.assumption));
        if (depths_.empty() && scene_ != nullptr)
            explain_edges();
        result_.explained = fit(result_.assumption);
        tell_assumption(result_, scene_ != nullptr ? mesh_extent(scene_->mesh()) : 0, shared_camera(), result_.findings);
        for (Finding& finding : result_.findings)
            finding.certain = contradicted();
        tell_figures(result_, result_.findings);
        if (depths_.empty() && std::ranges::any_of(views_, &View::depth_is_empty))
            tell(result_.findings, "empty_depth",
                 "the depth pictures are empty: all values in those of the inspected frames are 0 or 65535, which mean that "
                 "nothing "
                 "was measured; export the recording again, with its depth");
        judge_rest();
        return std::move(result_);
    }

  private:
    template <class Part>
    bool all_share(Part RigidTransform::*part) const
    {
        const auto of = [&](const View& view) { return view.depth.pose.*part; };
        return views_.size() > 1 && std::ranges::all_of(views_, [&](const View& view) { return of(view) == of(views_.front()); });
    }
    /// Whether an assumption that explains the recording is more than a guess. Frames that only hide each other may be right:
    /// views of equal rooms agree best if put into one place.
    bool contradicted() const
    {
        const Fit& fit = result_.recorded;
        if (scene_ != nullptr || (fit.covered_share > hardly_covered && fit.in_front > hardly_in_front))
            return true;
        const Assumption& a = result_.assumption;
        numerics::Bounds<double> cameras;
        for (const View& view : views_)
            cameras.add(view.depth.pose.translation);
        return std::abs(std::log10(a.depth_scale)) >= 1 ||
               (a.pose_scale < 1 && length(cameras.high - cameras.low) > largest_room);
    }
    /// Reports poses, positions or rotations that are all equal although the depths contradict that. Without depth, only equal
    /// poses are odd enough.
    bool tell_placeholders()
    {
        const bool positions = all_share(&RigidTransform::translation);
        const bool rotations = all_share(&RigidTransform::rotation);
        const Fit& fit = result_.explained;
        const bool odd = depths_.empty() ? positions && rotations && result_.outline_points >= fair_outline_points &&
                                               fit.edge_response < fair_response
                                         : (positions || rotations) && !fit.fits && fit.covered_share > hardly_covered &&
                                               fit.seen_through > clearly_seen_through;
        if (!odd)
            return false;
        tell_equal_poses(positions, rotations, result_.findings);
        return true;
    }
    bool shared_camera() const { return std::ranges::all_of(depths_, one_camera); }

    /// Views among themselves know only the quotient of two units. Depths that no room has tell which one is wrong.
    void choose_unit()
    {
        Assumption& a = result_.assumption;
        std::vector<double> depths;
        for (const DepthView& view : depths_)
            for (const DepthSample& sample : view.samples)
                depths.push_back(static_cast<double>(sample.depth));
        if (a.pose_scale == 1 || depths.empty())
            return;
        const auto is_of_room = [](double depth) { return depth > least_depth_m && depth < largest_depth_m; };
        if (const double usual = numerics::median(std::move(depths)); is_of_room(usual) || !is_of_room(usual / a.pose_scale))
            return;
        a.depth_scale = usual_scale(1 / a.pose_scale);
        a.pose_scale = 1;
    }

    Fit fit(const Assumption& assumption)
    {
        Fit fit;
        if (!depths_.empty())
        {
            const auto ratios = depth_ratios(scene_, depths_, assumption, 1);
            const Agreement sum = total(agreement(ratios, assumption.depth_scale));
            fit.fits = fits(sum) || sum.samples == 0;
            fit.covered_share = sum.covered_share();
            fit.agreement = sum.share();
            fit.median_error = median_error(ratios, assumption.depth_scale);
            fit.in_front = sum.covered() > 0 ? sum.in_front / sum.covered() : 0;
            fit.behind = sum.covered() > 0 ? sum.behind / sum.covered() : 0;
            fit.seen_through = sum.covered() > 0 ? sum.seen_through / sum.covered() : 0;
            result_.front_share = front_share(ratios, assumption.depth_scale);
        }
        fit.edge_response = edge_response(edge_views(assumption));
        return fit;
    }

    /// The color pictures and what should lie on their edges.
    std::vector<EdgeView> edge_views(const Assumption& assumption) const
    {
        std::vector<EdgeView> all;
        for (const View& view : views_)
            if (!view.edges.empty())
            {
                EdgeView& edge_view = all.emplace_back(EdgeView{view.color, &view.edges, {}});
                if (!depths_.empty())
                    add_outline(edge_view, measured_outline(view, assumption));
                else if (scene_ != nullptr)
                    add_outline(edge_view, mesh_outline(view, assumption));
            }
        return all;
    }

    std::vector<Vec3d> measured_outline(const View& view, const Assumption& assumption) const
    {
        const RigidTransform color_from_depth = view.depth.depth_from_color.inverse();
        std::vector<Vec3d> points;
        for (const DepthSample& sample : view.silhouette)
        {
            const MeasuredRay ray = measured_ray(view.depth, sample, assumption);
            const Vec3d point = ray.direction * ray.depth;
            points.push_back(assumption.by_color_camera ? point : color_from_depth.point(point));
        }
        return points;
    }

    std::vector<Vec3d> mesh_outline(const View& view, const Assumption& assumption) const
    {
        const Intrinsics k =
            view.color.scaled_to(std::max(1, view.color.width / outline_step_), std::max(1, view.color.height / outline_step_));
        const Camera camera{k, color_pose(view, assumption)};
        std::vector<Vec3d> points;
        for (const DepthSample& sample : silhouette(mesh_depth(*scene_, camera, progress_)))
            points.push_back({(static_cast<double>(sample.x) - k.cx) / k.fx, (static_cast<double>(sample.y) - k.cy) / k.fy, 1});
        return points;
    }

    static std::size_t points_of(const std::vector<EdgeView>& views)
    {
        std::size_t points = 0;
        for (const EdgeView& view : views)
            points += view.outline.size();
        return points;
    }

    /// Whether `after` is better than `before` by more than chance, and fits.
    static bool clearly_better(double before, double after, const std::vector<double>& before_of_frames,
                               const std::vector<double>& after_of_frames)
    {
        return after >= fair_response && after >= clearly * before && gains(before_of_frames, after_of_frames);
    }

    /// Without depth: the assumption under which the mesh's silhouettes lie on the pictures' edges.
    void explain_edges()
    {
        if (result_.recorded.edge_response >= fair_response && result_.outline_points >= fair_outline_points)
            return;
        outline_step_ = 2;
        const auto recorded = edge_views({});
        const double before = edge_response(recorded);
        const Look seen = look({});
        const double least_seen = std::max(0.1 * seen.pixels, 0.5 * seen.fronts);
        Assumption best;
        double most = before;
        for (const Hypothesis& hypothesis : common_hypotheses())
            for (const Assumption& variant : hypothesis.variants)
            {
                if (look(variant).fronts < least_seen)
                    continue;
                const auto views = edge_views(variant);
                const double response = edge_response(views);
                if (points_of(views) >= fair_outline_points && response > most + hypothesis.advantage)
                {
                    most = response;
                    best = variant;
                }
            }
        if (clearly_better(before, most, edge_responses(recorded), edge_responses(edge_views(best))))
            result_.assumption = best;
        outline_step_ = 1;
    }

    struct Look
    {
        double pixels = 0;
        double seen = 0;
        double fronts = 0;
    };

    /// Comparison of the mesh with the color cameras' pictures.
    Look look(const Assumption& assumption) const
    {
        const bool mirrored = determinant(assumption.world_turn) < 0;
        Look look;
        for (const View& view : views_)
        {
            const Camera camera{view.color, color_pose(view, assumption)};
            for (std::size_t i = 0; i < view.pixels.size(); i += look_stride)
            {
                const raycast::Hit hit = seen_at(*scene_, camera, view.pixels[i]);
                ++look.pixels;
                look.seen += hit.found();
                look.fronts += hit.found() && hit.front != mirrored;
            }
        }
        return look;
    }

    /// Painting with a wrong focal length blurs the whole texture, and depths do not show it.
    void judge_color_focal()
    {
        const auto recorded = edge_views(result_.assumption);
        auto tried = recorded;
        std::vector<double> best = edge_responses(recorded);
        double most = result_.explained.edge_response;
        double mending = 1;
        for (int step = -color_focal_steps; step <= color_focal_steps; ++step)
        {
            const double factor = std::exp(color_focal_reach * step / color_focal_steps);
            for (std::size_t i = 0; i < tried.size(); ++i)
                tried[i].camera = scaled(recorded[i].camera, 1, factor);
            if (const double response = edge_response(tried); response > most)
            {
                most = response;
                best = edge_responses(tried);
                mending = factor;
            }
        }
        if (points_of(recorded) < fair_outline_points ||
            !clearly_better(result_.explained.edge_response, most, edge_responses(recorded), best))
            return;
        tell_color_focal(mending, result_.explained.edge_response, most, result_.findings);
        result_.explained.edge_response = most;
    }

    void judge_rest()
    {
        const Fit& fit = result_.explained;
        if (tell_placeholders())
            return;
        if (depths_.empty())
        {
            const Look seen = scene_ != nullptr ? look(result_.assumption) : Look{};
            if (seen.pixels > 0 && seen.seen == 0)
                tell_uncovered(true, result_.findings);
            else if (seen.fronts < 0.2 * seen.seen)
                tell_inside_out(result_.findings);
        }
        else if (!fit.fits && fit.covered_share < hardly_covered)
            tell_uncovered(scene_ != nullptr, result_.findings);
        else if (!fit.fits)
            tell_disagreement(
                fit, scene_ != nullptr,
                (scene_ != nullptr && fit.agreement < hopeless) ||
                    (fit.in_front > contradicting && fit.agreement < 0.3 && fit.seen_through > clearly_seen_through),
                result_.findings);
        else if (result_.front_share < 0.2 && determinant(result_.assumption.world_turn) > 0)
            tell_inside_out(result_.findings);
        if (!depths_.empty() && fit.fits)
            judge_color_focal();
        if (result_.findings.empty() && result_.outline_points >= fair_outline_points && fit.edge_response < no_response)
            tell(result_.findings, "unexplained_edges",
                 "the color pictures have no edges along the outlines: are they turned by 180 degrees, or are the color camera's "
                 "intrinsics those of another picture size or camera? See the picture that scan.inspect draws",
                 false);
    }

    const raycast::Scene* scene_;
    const std::vector<View>& views_;
    const Progress& progress_;
    std::vector<DepthView> depths_;
    int outline_step_ = 1;  ///< Pixels of the edges per pixel of the mesh's outline.
    Diagnosis result_;
};

}  // namespace

std::pair<Camera, Camera> explained_cameras(const Diagnosis& diagnosis, const View& view)
{
    const Assumption& a = diagnosis.assumption;
    return {{view.color, color_pose(view, a)}, {a.depth_camera(view.depth.depth, view.depth.color), depth_pose(view.depth, a)}};
}

void correct_depth(const Diagnosis& diagnosis, const View& view, RasterF& depth)
{
    const Assumption& a = diagnosis.assumption;
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
        {
            const DepthSample sample{static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, depth.at(x, y)};
            depth.at(x, y) = static_cast<float>(measured_ray(view.depth, sample, a).depth * a.depth_scale);
        }
    if (a.upside_down)
        std::ranges::reverse(depth.values);
}

Diagnosis diagnose(const raycast::Scene* scene, const std::vector<View>& views, const Progress& progress)
{
    return Judge(scene, views, progress).judge();
}

}  // namespace fresco::inspect
