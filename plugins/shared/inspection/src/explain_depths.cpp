#include "explain_depths.h"

#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>

namespace fresco::inspect
{
namespace
{

constexpr std::array readings{Reading::transposed, Reading::scalar_first, Reading::scalar_last, Reading::inverted_scalar_first,
                              Reading::inverted_scalar_last};
constexpr std::array usual_units{1.0, 0.001, 1000.0, 0.01, 100.0};
constexpr std::array sizes{0.5, 2.0, 0.25, 1.0 / 3, 2.0 / 3, 1.5, 3.0, 4.0};
constexpr double widest_scale = 2000;

template <class Set>
std::vector<Assumption> around(const Assumption& assumed, double reach, double step, const Set& set)
{
    std::vector<Assumption> variants;
    const auto steps = static_cast<int>(std::lround(reach / step));
    for (int i = -steps; i <= steps; ++i)
        if (i != 0)
            set(variants.emplace_back(assumed), i * step);
    return variants;
}

/// Poses in usual units, inverted or not, with these camera axes.
std::vector<Assumption> conventions(std::span<const Mat3> cameras)
{
    std::vector<Assumption> all;
    for (const double scale : usual_units)
        for (const Reading reading : {Reading::as_recorded, Reading::inverted})
            for (const Mat3& camera : cameras)
                all.push_back({.reading = reading, .pose_scale = scale, .camera_turn = camera});
    return all;
}

Hypothesis all_conventions()
{
    const auto& turns = axis_rotations();
    Hypothesis all{.variants = conventions(turns), .any_depth_scale = true};
    // The plain ones first: they win if others are as good.
    std::ranges::stable_partition(all.variants, [&](const Assumption& variant) { return variant.camera_turn == turns[1]; });
    std::ranges::stable_partition(all.variants, [&](const Assumption& variant) { return variant.camera_turn == turns[0]; });
    return all;
}

/// Turned by right angles, or mirrored.
Hypothesis worlds(bool mirrored)
{
    const auto& turns = axis_rotations();
    Mat3 mirror;
    mirror(0, 0) = -1;
    Hypothesis all{.variants = {}, .any_depth_scale = true};
    for (const Mat3& turn : turns)
        if (mirrored || !(turn == turns.front()))
            for (const Reading reading : {Reading::as_recorded, Reading::inverted})
                for (const Mat3& camera : {turns[0], turns[1]})
                    all.variants.push_back(
                        {.reading = reading, .camera_turn = camera, .world_turn = mirrored ? turn * mirror : turn});
    return all;
}

/// OpenGL axes hide other intrinsics, and the reverse.
Hypothesis axes_and_sizes()
{
    Hypothesis all;
    for (const double size : {0.5, 2.0})
        for (const Reading reading : {Reading::as_recorded, Reading::inverted})
            all.variants.push_back({.reading = reading, .camera_turn = axis_rotations()[1], .size_scale = size});
    return all;
}

Hypothesis rotations()
{
    Hypothesis all;
    const auto& turns = axis_rotations();
    for (const Mat3& camera : {turns[0], turns[1]})
        for (const Reading reading : readings)
            all.variants.push_back({.reading = reading, .camera_turn = camera});
    return all;
}

Hypothesis any_unit(double reach)
{
    Hypothesis all{.variants = {}, .any_depth_scale = true};
    const auto& turns = axis_rotations();
    const double step = std::clamp(0.05 / reach, 0.01, 0.04);
    for (const Mat3& camera : {turns[0], turns[1]})
        for (const Assumption& variant : around({.camera_turn = camera}, std::log(widest_scale), step,
                                                [](Assumption&a, double offset) { a.pose_scale = std::exp(offset); }))
            all.variants.push_back(variant);
    return all;
}

/// Likely mistakes of a recording that partly agrees, the most likely first, each on top of `assumed`: another depth unit, the
/// color camera's intrinsics, pictures that are upside down, distances along rays, intrinsics of another size, focal lengths,
/// another unit of the poses.
std::vector<Hypothesis> small_hypotheses(const Assumption& assumed, const std::vector<DepthView>& views)
{
    std::vector<Hypothesis> table;
    const auto add = [&](const auto& set)
    {
        set(table.emplace_back(Hypothesis{.variants = {assumed}}).variants.front());
        if (table.back().variants.front() == assumed)
            table.pop_back();
    };
    table.push_back({.variants = {assumed}, .any_depth_scale = true});
    if (!std::ranges::all_of(views, one_camera))
        add([](Assumption& a) { a.by_color_camera = true; });
    add([](Assumption& a) { a.upside_down = true; });
    add([](Assumption& a) { a.along_ray = true; });
    if (assumed.size_scale == 1)
    {
        auto& variants = table.emplace_back().variants;
        for (const double size : sizes)
            variants.emplace_back(assumed).size_scale = size;
    }
    if (assumed.focal_scale == 1)
        table.push_back({.variants = around(assumed, focal_reach, 0.03,
                                            [](Assumption& a, double offset) { a.focal_scale = std::exp(offset); })});
    if (assumed.pose_scale == 1)
        table.push_back(
            {.variants = around(assumed, 0.7, 0.02, [](Assumption& a, double offset) { a.pose_scale = std::exp(offset); })});
    return table;
}

/// Mistakes that displace everything: axes, inverted poses, units, a turned or mirrored mesh, quaternions, transposed rotations.
/// Frames among themselves know no turned world. `reach`: how many times farther cameras are from the origin than from the
/// surface; large ones need finer steps of scale.
std::vector<Hypothesis> large_hypotheses(double reach, bool with_mesh)
{
    if (!with_mesh)
        return {all_conventions(), rotations(), any_unit(reach), axes_and_sizes()};
    return {all_conventions(), worlds(false), worlds(true), rotations(), any_unit(reach), axes_and_sizes()};
}

}  // namespace

std::vector<Hypothesis> common_hypotheses()
{
    std::vector<Hypothesis> table(2);  // Conventions and mirrored meshes.
    table[0].variants = conventions(std::span(axis_rotations()).first(2));
    for (const int axis : {0, 1, 2})
        table[1].variants.emplace_back().world_turn(axis, axis) = -1;
    table.push_back(rotations());
    return table;
}

namespace
{

/// Samples of all frames that a first look takes.
constexpr std::size_t rough_samples = 1600;
/// Doubts about hypotheses under which hardly anything is covered, as a share of the samples.
constexpr double doubt = 0.02;
/// A recording in which so much agrees has no mistake that leaves nothing where it was.
constexpr double no_large_mistake = 0.6;
/// Covered by so much, a recording cannot agree by chance in a small part.
constexpr double covered_by_most = 0.5;
/// Agreement without a mistake to explain.
constexpr double no_mistake = 0.9;
/// Candidates this near to the best, as a share of its score, are refined.
constexpr double promising = 0.75;
/// All variants are scored on every glance_stride-th sample, and the best ones scored again on all.
constexpr std::size_t finalists = 12;
constexpr std::size_t glance_stride = 7;
constexpr int most_mistakes = 3;
/// Mistakes below these are left to calibration and to frames.align.
constexpr double least_focal = 0.04;
constexpr double least_scale = 0.015;

double score(const Agreement& sum)
{
    const double weight = sum.agreeing + sum.in_front + 0.5 * sum.behind + doubt * sum.samples;
    return weight > 0 ? sum.agreeing / weight : 0;
}

/// An assumption and how the frames agree with the mesh under it.
struct Judged
{
    Assumption assumption;
    std::vector<Agreement> frames;
};

struct Candidate
{
    Assumption assumption;
    double score = 0;
    double advantage = 0;
};

class Search
{
  public:
    Search(const raycast::Scene* scene, const std::vector<DepthView>& views, const Progress& progress)
        : scene_(scene), views_(views), progress_(progress)
    {
        std::size_t samples = 0;
        std::vector<double> depths;
        std::vector<double> positions;
        for (const DepthView& view : views)
        {
            samples += view.samples.size();
            positions.push_back(length(view.pose.translation));
            for (const DepthSample& sample : view.samples)
                depths.push_back(static_cast<double>(sample.depth));
        }
        stride_ = std::max<std::size_t>(1, samples / rough_samples);
        if (!depths.empty())
            reach_ = numerics::median(std::move(positions)) / numerics::median(std::move(depths));
    }

    Judged run()
    {
        const Judged recorded = full({});
        Judged found = recorded;
        for (int i = 0; i < most_mistakes; ++i)
        {
            const Judged next = step(found, i == 0);
            if (!improves(found.frames, next.frames))
                break;
            found = next;
        }
        found = plain(found);
        return explains(recorded.frames, found.frames, scene_ != nullptr) ? found : recorded;
    }

  private:
    /// Judged by all samples.
    Judged full(const Assumption& assumption) const
    {
        return {assumption, agreement(depth_ratios(scene_, views_, assumption, 1), assumption.depth_scale)};
    }

    Judged step(const Judged& from, bool first) const
    {
        const Agreement sum = total(from.frames);
        std::vector<Hypothesis> table;
        if (sum.share() < no_mistake)
            table = small_hypotheses(from.assumption, views_);
        if (first && (sum.share() < no_large_mistake || sum.covered_share() < covered_by_most))
            for (Hypothesis& large : large_hypotheses(reach_, scene_ != nullptr))
                table.push_back(std::move(large));
        std::vector<Candidate> candidates{rough(from.assumption, false, stride_)};
        for (const Hypothesis& hypothesis : table)
            candidates.push_back(best_variant(hypothesis));
        return full(best_of(candidates).assumption);
    }

    /// Later ones must beat those before by their advantage, after the promising ones have been refined.
    Candidate best_of(std::vector<Candidate> candidates) const
    {
        const double most = std::ranges::max(candidates, {}, &Candidate::score).score;
        Candidate best;
        for (const Candidate& candidate : candidates)
        {
            if (candidate.score < promising * most)
                continue;
            const Candidate fine = refined(candidate);
            if (best.score == 0 || fine.score > best.score + fine.advantage)
                best = fine;
        }
        return best;
    }

    /// With the depth scale that suits best, or as it is.
    Candidate rough(Assumption assumption, bool any_depth_scale, std::size_t stride) const
    {
        const auto ratios = depth_ratios(scene_, views_, assumption, stride);
        if (any_depth_scale && scene_ != nullptr)
            assumption.depth_scale = best_scale(ratios);
        return {assumption, score(total(agreement(ratios, assumption.depth_scale))), 0};
    }

    std::vector<Candidate> look_at(const std::vector<Assumption>& variants, bool any_depth_scale, std::size_t stride) const
    {
        std::vector<Candidate> all(variants.size());
        parallel_items(all.size(), 1, progress_, [&](std::size_t i) { all[i] = rough(variants[i], any_depth_scale, stride); });
        return all;
    }

    Candidate best_variant(const Hypothesis& hypothesis) const
    {
        std::vector<Assumption> variants = hypothesis.variants;
        if (variants.size() > 2 * finalists)
        {
            const auto glances = look_at(variants, hypothesis.any_depth_scale, stride_ * glance_stride);
            std::vector<std::size_t> order(variants.size());
            std::iota(order.begin(), order.end(), std::size_t{0});
            std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return glances[i].score; });
            order.resize(finalists);
            // As in the table, in which likely ones come first.
            std::ranges::sort(order);
            variants.clear();
            for (const std::size_t i : order)
                variants.push_back(hypothesis.variants[i]);
        }
        Candidate best{hypothesis.variants.front()};
        for (const Candidate& candidate : look_at(variants, hypothesis.any_depth_scale, stride_))
            if (candidate.score > best.score * 1.02)
                best = candidate;
        best.advantage = hypothesis.advantage;
        return best;
    }

    /// Continuous mistakes in ever finer steps.
    Candidate refined(Candidate best) const
    {
        for (double step = 0.02; step > 0.001; step /= 2)
            for (const double sign : {-1.0, 1.0})
            {
                progress_.check_canceled();
                const auto attempt = [&](bool there, const auto& set)
                {
                    if (!there)
                        return;
                    Assumption changed = best.assumption;
                    set(changed);
                    if (const Candidate candidate = rough(changed, false, stride_); candidate.score > best.score)
                    {
                        best.assumption = candidate.assumption;
                        best.score = candidate.score;
                    }
                };
                const double factor = std::exp(sign * step);
                attempt(best.assumption.focal_scale != 1, [&](Assumption& a) { a.focal_scale *= factor; });
                attempt(best.assumption.pose_scale != 1, [&](Assumption& a) { a.pose_scale *= factor; });
                attempt(best.assumption.depth_scale != 1, [&](Assumption& a) { a.depth_scale *= factor; });
                attempt(best.assumption.pose_scale != 1 && best.assumption.depth_scale != 1,
                        [&](Assumption& a)
                        {
                            a.pose_scale *= factor;
                            a.depth_scale *= factor;
                        });
            }
        return best;
    }

    /// Without mistakes that are too small to tell, or that explain nothing beside the others.
    Judged plain(Judged found) const
    {
        const auto drop = [&](bool small, const auto& reset)
        {
            Assumption without = found.assumption;
            reset(without);
            if (without == found.assumption)
                return;
            const Judged judged = full(without);
            if (small || !improves(judged.frames, found.frames))
                found = judged;
        };
        const Assumption none;
        const Assumption& a = found.assumption;
        const auto below = [](double factor, double least) { return std::abs(std::log(factor)) < least; };
        drop(below(a.focal_scale, least_focal), [&](Assumption& x) { x.focal_scale = none.focal_scale; });
        drop(below(a.pose_scale, least_scale), [&](Assumption& x) { x.pose_scale = none.pose_scale; });
        drop(below(a.depth_scale, least_scale), [&](Assumption& x) { x.depth_scale = none.depth_scale; });
        snap(found, [](Assumption& x) -> double& { return x.pose_scale; });
        snap(found, [](Assumption& x) -> double& { return x.depth_scale; });
        drop(false, [&](Assumption& x) { x.along_ray = false; });
        drop(false, [&](Assumption& x) { x.upside_down = false; });
        drop(false, [&](Assumption& x) { x.by_color_camera = false; });
        drop(false, [&](Assumption& x) { x.size_scale = none.size_scale; });
        drop(false, [&](Assumption& x) { x.reading = none.reading; });
        drop(false, [&](Assumption& x) { x.camera_turn = none.camera_turn; });
        drop(false, [&](Assumption& x) { x.world_turn = none.world_turn; });
        return found;
    }

    /// A usual factor in place of one near it.
    template <class Scale>
    void snap(Judged& found, const Scale& scale) const
    {
        Assumption usual = found.assumption;
        scale(usual) = usual_scale(scale(usual));
        if (usual == found.assumption)
            return;
        const Judged judged = full(usual);
        if (!improves(judged.frames, found.frames))
            found = judged;
    }

    const raycast::Scene* scene_;
    const std::vector<DepthView>& views_;
    const Progress& progress_;
    std::size_t stride_ = 1;
    double reach_ = 1;
};

}  // namespace

Assumption explain_depths(const raycast::Scene* scene, const std::vector<DepthView>& views, const Progress& progress)
{
    return Search(scene, views, progress).run().assumption;
}

}  // namespace fresco::inspect
