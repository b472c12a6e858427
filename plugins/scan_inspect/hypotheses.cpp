#include "hypotheses.h"

#include <algorithm>
#include <array>
#include <cmath>

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

Hypothesis conventions()
{
    const auto& turns = axis_rotations();
    Hypothesis all{.name = "convention", .variants = {}, .any_depth_scale = true};
    for (const double scale : usual_units)
        for (const Reading reading : {Reading::as_recorded, Reading::inverted})
            for (const Mat3& camera : turns)
                all.variants.push_back({.reading = reading, .pose_scale = scale, .camera_turn = camera});
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
    Hypothesis all{.name = mirrored ? "mirrored mesh" : "turned world", .variants = {}, .any_depth_scale = true};
    for (const Mat3& turn : turns)
        if (mirrored || !(turn == turns.front()))
            for (const Reading reading : {Reading::as_recorded, Reading::inverted})
                for (const Mat3& camera : {turns[0], turns[1]})
                    all.variants.push_back(
                        {.reading = reading, .camera_turn = camera, .world_turn = mirrored ? turn * mirror : turn});
    return all;
}

Hypothesis rotations()
{
    Hypothesis all{.name = "rotations", .variants = {}};
    const auto& turns = axis_rotations();
    for (const Mat3& camera : {turns[0], turns[1]})
        for (const Reading reading : readings)
            all.variants.push_back({.reading = reading, .camera_turn = camera});
    return all;
}

Hypothesis any_unit(double reach)
{
    Hypothesis all{.name = "unit", .variants = {}, .any_depth_scale = true};
    const auto& turns = axis_rotations();
    const double step = std::clamp(0.05 / reach, 0.01, 0.04);
    for (const Mat3& camera : {turns[0], turns[1]})
        for (const Assumption& variant : around({.camera_turn = camera}, std::log(widest_scale), step,
                                                [](Assumption&a, double offset) { a.pose_scale = std::exp(offset); }))
            all.variants.push_back(variant);
    return all;
}

Hypothesis lags(const Assumption& assumed, double reach, double step)
{
    return {.name = "lag", .variants = around(assumed, reach, step, [](Assumption& a, double offset) { a.lag_frames = offset; })};
}

bool has_tracks(const std::vector<DepthView>& views)
{
    return std::ranges::any_of(views, [](const DepthView& view) { return view.track.poses.size() > 1; });
}

}  // namespace

bool one_camera(const DepthView& view)
{
    const Intrinsics color = view.color.scaled_to(view.depth.width, view.depth.height);
    return std::abs(color.fx / view.depth.fx - 1) < 0.002 && std::abs(color.fy / view.depth.fy - 1) < 0.002 &&
           std::abs(color.cx - view.depth.cx) < 0.002 * view.depth.width &&
           std::abs(color.cy - view.depth.cy) < 0.002 * view.depth.width && view.depth_from_color.rotation_error() < 1e-6 &&
           length(view.depth_from_color.translation) < 1e-4;
}

std::vector<Hypothesis> small_hypotheses(const Assumption& assumed, const std::vector<DepthView>& views)
{
    std::vector<Hypothesis> table;
    const auto add = [&](const char* name, const auto& set)
    {
        set(table.emplace_back(Hypothesis{.name = name, .variants = {assumed}}).variants.front());
        if (table.back().variants.front() == assumed)
            table.pop_back();
    };
    table.push_back({.name = "depth unit", .variants = {assumed}, .any_depth_scale = true});
    if (!std::ranges::all_of(views, one_camera))
        add("color camera", [](Assumption& a) { a.by_color_camera = true; });
    add("upside down", [](Assumption& a) { a.upside_down = true; });
    add("along rays", [](Assumption& a) { a.along_ray = true; });
    if (assumed.size_scale == 1)
    {
        auto& variants = table.emplace_back(Hypothesis{.name = "size", .variants = {}}).variants;
        for (const double size : sizes)
            variants.emplace_back(assumed).size_scale = size;
    }
    if (assumed.focal_scale == 1)
        table.push_back({.name = "focal length",
                         .variants = around(assumed, focal_reach, 0.03,
                                            [](Assumption& a, double offset) { a.focal_scale = std::exp(offset); })});
    if (assumed.lag_frames == 0 && has_tracks(views))
        table.push_back(lags(assumed, lag_reach, 0.25));
    if (assumed.pose_scale == 1)
        table.push_back(
            {.name = "pose unit",
             .variants = around(assumed, 0.7, 0.02, [](Assumption& a, double offset) { a.pose_scale = std::exp(offset); })});
    return table;
}

std::vector<Hypothesis> large_hypotheses(double reach)
{
    return {conventions(), worlds(false), worlds(true), rotations(), any_unit(reach)};
}

std::vector<Hypothesis> common_hypotheses(const std::vector<DepthView>& views)
{
    const auto& turns = axis_rotations();
    std::vector<Hypothesis> table{{.name = "convention", .variants = {}}, {.name = "mirrored mesh", .variants = {}}};
    for (const double scale : usual_units)
        for (const Reading reading : {Reading::as_recorded, Reading::inverted})
            for (const Mat3& camera : {turns[0], turns[1]})
                table[0].variants.push_back({.reading = reading, .pose_scale = scale, .camera_turn = camera});
    for (const int axis : {0, 1, 2})
        table[1].variants.emplace_back().world_turn(axis, axis) = -1;
    table.push_back(rotations());
    if (has_tracks(views))
        table.push_back(lags({}, 2, 0.5));
    return table;
}

}  // namespace fresco::inspect
