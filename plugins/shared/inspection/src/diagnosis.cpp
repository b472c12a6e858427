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
constexpr double no_response = 0.04;
/// A change of the color camera must be so many times as good as the recorded one.
constexpr double clearly = 1.6;
constexpr std::size_t fair_outline_points = 300;
/// Smaller errors of a camera are within what a calibration leaves.
constexpr double focal_tolerance = 0.04;
constexpr double shift_tolerance = 0.015;
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

RigidTransform color_pose(const View& view, const Assumption& assumption, bool by_depth_camera)
{
    const RigidTransform pose = assumption.pose(view.depth.track);
    return by_depth_camera ? pose : pose * view.depth.depth_from_color;
}

Intrinsics color_camera(const View& view, bool by_depth_camera)
{
    return by_depth_camera ? view.depth.depth.scaled_to(view.color.width, view.color.height) : view.color;
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
        const std::size_t by_depth = result_.findings.size();
        for (Finding& finding : result_.findings)
            finding.certain = contradicted();
        if (depths_.empty() || result_.explained.fits)
            judge_color();
        tell_figures(result_, by_depth, result_.findings);
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
        const auto of = [&](const View& view) { return view.depth.track.poses[view.depth.track.own].*part; };
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
            cameras.add(view.depth.track.poses[view.depth.track.own].translation);
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
        fit.edge_response = edge_response(edge_views(assumption), {});
        return fit;
    }

    /// The color pictures and what should lie on their edges.
    std::vector<EdgeView> edge_views(const Assumption& assumption, bool by_depth_camera = false) const
    {
        std::vector<EdgeView> all;
        for (const View& view : views_)
            if (!view.edges.empty())
            {
                EdgeView& edge_view = all.emplace_back(EdgeView{color_camera(view, by_depth_camera), &view.edges, {}});
                if (!depths_.empty())
                    add_outline(edge_view, measured_outline(view, assumption, by_depth_camera));
                else if (scene_ != nullptr)
                    add_outline(edge_view, mesh_outline(view, assumption));
            }
        return all;
    }

    /// The cameras' distance from each other is in meters or in the unit that the depths turned out to have.
    void find_meters()
    {
        const double recorded = edge_response(edge_views(result_.assumption), {});
        meters_ = result_.assumption.depth_scale;
        if (edge_response(edge_views(result_.assumption), {}) <= recorded)
            meters_ = 1;
        result_.explained.edge_response = edge_response(edge_views(result_.assumption), {});
    }

    std::vector<Vec3d> measured_outline(const View& view, const Assumption& assumption, bool by_depth_camera) const
    {
        const RigidTransform color_from_depth = view.depth.depth_from_color.inverse();
        std::vector<Vec3d> points;
        for (const DepthSample& sample : view.silhouette)
        {
            const MeasuredRay ray = measured_ray(view.depth, sample, assumption);
            Vec3d point = ray.direction * (ray.depth * meters_);
            if (assumption.by_color_camera && by_depth_camera)
                point = view.depth.depth_from_color.point(point);
            else if (assumption.by_color_camera == by_depth_camera)
                point = color_from_depth.point(point);
            points.push_back(point);
        }
        return points;
    }

    std::vector<Vec3d> mesh_outline(const View& view, const Assumption& assumption) const
    {
        const Intrinsics k =
            view.color.scaled_to(std::max(1, view.color.width / outline_step_), std::max(1, view.color.height / outline_step_));
        const Camera camera{k, color_pose(view, assumption, false)};
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
        const double before = edge_response(recorded, {});
        const Look seen = look({});
        const double least_seen = std::max(0.1 * seen.pixels, 0.5 * seen.fronts);
        const bool has_tracks = std::ranges::any_of(views_, [](const View& view) { return view.depth.track.poses.size() > 1; });
        Assumption best;
        double most = before;
        for (const Hypothesis& hypothesis : common_hypotheses(has_tracks))
            for (const Assumption& variant : hypothesis.variants)
            {
                if (look(variant).fronts < least_seen)
                    continue;
                const auto views = edge_views(variant);
                const double response = edge_response(views, {});
                if (points_of(views) >= fair_outline_points && response > most + hypothesis.advantage)
                {
                    most = response;
                    best = variant;
                }
            }
        if (clearly_better(before, most, edge_responses(recorded, {}), edge_responses(edge_views(best), {})))
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
            const Camera camera{view.color, color_pose(view, assumption, false)};
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

    void judge_color()
    {
        find_meters();
        const auto views = edge_views(result_.assumption);
        if (points_of(views) >= fair_outline_points)
            judge_color_camera(views);
        tell_color(result_, shared_camera() && !depths_.empty(), result_.findings);
    }

    void judge_color_camera(const std::vector<EdgeView>& views)
    {
        const Assumption& a = result_.assumption;
        const double before = edge_response(views, {});
        CameraChange best;
        double most = before;
        const auto consider = [&](const CameraChange& change, double advantage)
        {
            if (const double response = edge_response(views, change); response > most * advantage)
            {
                most = response;
                best = change;
            }
        };
        consider({.focal_scale = a.focal_scale, .size_scale = a.size_scale, .upside_down = a.upside_down}, 1);
        consider({.upside_down = true}, 1.05);
        for (const double size : {0.5, 2.0, 0.25, 1.0 / 3, 2.0 / 3, 1.5, 3.0, 4.0})
            consider({.size_scale = size}, 1.05);
        for (const double focal : {0.5, 2.0})
            consider({.focal_scale = focal}, 1.05);
        const bool discrete = best.size_scale != 1 || best.upside_down || best.focal_scale == 0.5 || best.focal_scale == 2;
        if (!discrete)
            consider(best_change(views, progress_), 1.05);
        bool by_depth_camera = false;
        std::vector<double> responses = edge_responses(views, best);
        if (!depths_.empty() && !shared_camera())
        {
            const auto by_depth = edge_views(a, true);
            if (const double response = edge_response(by_depth, {}); response > 0.95 * most && response > clearly * before)
            {
                most = response;
                by_depth_camera = true;
                responses = edge_responses(by_depth, {});
            }
        }
        const bool off = by_depth_camera || discrete || std::abs(std::log(best.focal_scale)) >= focal_tolerance ||
                         std::abs(best.shift_x) >= shift_tolerance || std::abs(best.shift_y) >= shift_tolerance;
        if (!off || !clearly_better(before, most, edge_responses(views, {}), responses))
            return;
        result_.color_by_depth_camera = by_depth_camera;
        if (!by_depth_camera)
            result_.color_change = best;
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
        if (result_.findings.empty() && result_.outline_points >= fair_outline_points && fit.edge_response < no_response)
            tell(result_.findings, "unexplained_edges",
                 "the color pictures have no edges along the outlines, and no usual mistake explains it: look at the pictures",
                 false);
    }

    const raycast::Scene* scene_;
    const std::vector<View>& views_;
    const Progress& progress_;
    std::vector<DepthView> depths_;
    int outline_step_ = 1;  ///< Pixels of the edges per pixel of the mesh's outline.
    double meters_ = 1;     ///< Per unit of the recorded depths.
    Diagnosis result_;
};

}  // namespace

std::pair<Camera, Camera> explained_cameras(const Diagnosis& diagnosis, const View& view)
{
    const bool by_depth = diagnosis.color_by_depth_camera;
    const Assumption& a = diagnosis.assumption;
    return {{changed(color_camera(view, by_depth), diagnosis.color_change), color_pose(view, a, by_depth)},
            {a.depth_camera(view.depth.depth, view.depth.color), depth_pose(view.depth, a)}};
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
