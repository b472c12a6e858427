#include "tum.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>

namespace tum
{
namespace
{

using namespace fresco::recordings;

/// Walks the records; `take` gets the words behind the time.
void each_record(std::string_view text, std::string_view source, std::size_t words_expected, std::string_view form,
                 const std::function<void(double, const std::vector<std::string_view>&, const std::string&)>& take)
{
    LineReader lines(text, source);
    bool any = false;
    double last = 0;
    while (const auto line = lines.next_record())
    {
        const auto place = lines.place();
        const auto words = words_of(*line);
        if (words.size() != words_expected)
            throw fresco::Error(fmt::format("{}: {} words; expected \"{}\"", place, words.size(), form));
        const double time = number_of(words[0], place);
        if (any && !(time > last))
            throw fresco::Error(place + ": the time " + std::string(words[0]) +
                                " is not later than the line before; expected ascending times");
        any = true;
        last = time;
        take(time, words, place);
    }
    if (!any)
        throw fresco::Error(std::string(source) + ": the list is empty; expected lines \"" + std::string(form) + "\"");
}

/// The entry nearest to `time`, the earlier one of two; the list is sorted and not empty.
template <class T>
std::size_t nearest(const std::vector<T>& list, double time)
{
    const auto after =
        std::lower_bound(list.begin(), list.end(), time, [](const T& entry, double t) { return entry.time_s < t; });
    const auto index = static_cast<std::size_t>(after - list.begin());
    if (index == list.size())
        return index - 1;
    return index > 0 && time - list[index - 1].time_s <= list[index].time_s - time ? index - 1 : index;
}

template <class T>
std::string span_text(const std::vector<T>& list)
{
    return list.front().source + " begins at " + fresco::to_json(list.front().time_s) + ", ends at " +
           fresco::to_json(list.back().time_s);
}

void note_gap(double gap_s, double& smallest_s)
{
    smallest_s = smallest_s > 0 ? std::min(smallest_s, gap_s) : gap_s;
}

}  // namespace

std::string gaps_text(const Association& found)
{
    // Rounded up to a millisecond, so that it can be used as the option.
    const auto gap = [](double gap_s) { return fresco::to_json(std::ceil(gap_s * 1000 - 1e-6) / 1000) + " s"; };
    std::string text;
    if (found.depth_gap_s > 0)
        text = "the nearest depth picture is " + gap(found.depth_gap_s) + " away";
    if (found.pose_gap_s > 0)
        text += (text.empty() ? "" : ", ") + ("the nearest pose is " + gap(found.pose_gap_s) + " away");
    return text;
}

std::vector<StampedPicture> parse_pictures(std::string_view text, std::string_view source)
{
    std::vector<StampedPicture> pictures;
    each_record(text, source, 2, "timestamp filename",
                [&](double time, const std::vector<std::string_view>& words, const std::string& place) {
                    pictures.push_back({time, std::string(words[1]), place});
                });
    return pictures;
}

std::vector<StampedPose> parse_poses(std::string_view text, std::string_view source)
{
    std::vector<StampedPose> poses;
    each_record(text, source, 8, "timestamp tx ty tz qx qy qz qw",
                [&](double time, const std::vector<std::string_view>& words, const std::string& place)
                {
                    const auto n = [&](std::size_t i) { return number_of(words[i], place); };
                    poses.push_back({time, quaternion_transform(n(7), n(4), n(5), n(6), {n(1), n(2), n(3)}, place), place});
                });
    return poses;
}

Association associate(const std::vector<StampedPicture>& color, const std::vector<StampedPicture>& depth,
                      const std::vector<StampedPose>& poses, double max_gap_s, const std::filesystem::path& folder)
{
    Association result;
    for (std::size_t i = 0; i < color.size(); ++i)
    {
        const double time = color[i].time_s;
        const auto& partner = depth[nearest(depth, time)];
        const double depth_gap_s = std::abs(partner.time_s - time);
        const bool is_partner = nearest(color, partner.time_s) == i;
        if (depth_gap_s > max_gap_s || !is_partner)
        {
            ++result.without_depth;
            if (is_partner)
                note_gap(depth_gap_s, result.depth_gap_s);
            continue;
        }
        const auto& pose = poses[nearest(poses, time)];
        if (const double gap_s = std::abs(pose.time_s - time); gap_s > max_gap_s)
        {
            ++result.without_pose;
            note_gap(gap_s, result.pose_gap_s);
            continue;
        }
        RecordedView view;
        name_by_picture(view, color[i].name);
        view.number = static_cast<long>(i);
        view.color = folder / color[i].name;
        view.depth = folder / partner.name;
        view.world_from_camera = pose.world_from_camera;
        view.source = color[i].source;
        result.views.push_back(std::move(view));
    }
    if (result.views.empty())
        throw fresco::Error("no color picture has a depth picture and a pose within max_gap_s (" + fresco::to_json(max_gap_s) +
                            " s): " + gaps_text(result) + "; " + span_text(color) + "; " + span_text(depth) + "; " +
                            span_text(poses) + "; use lists of one recording, or set a larger max_gap_s");
    return result;
}

namespace
{

struct Known
{
    std::string_view name;
    std::string_view in_folder;
    std::array<double, 4> intrinsics;
    std::array<double, 5> distortion;
};

// Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012, and the data set's page on calibration.
constexpr std::array<Known, 4> known_cameras{{
    {"freiburg1", "freiburg1", {517.3, 516.5, 318.6, 255.3}, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
    {"freiburg2", "freiburg2", {520.9, 521.0, 325.1, 249.7}, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
    {"freiburg3", "freiburg3", {535.4, 539.2, 320.1, 247.6}, {0, 0, 0, 0, 0}},
    {"ros_default", "", {525.0, 525.0, 319.5, 239.5}, {0, 0, 0, 0, 0}},
}};

const Known& known_camera(std::string_view name, const std::filesystem::path& folder)
{
    const auto full = std::filesystem::weakly_canonical(folder);
    const auto folder_name = (full.has_filename() ? full : full.parent_path()).filename().string();
    for (const auto& known : known_cameras)
        if (name == known.name ||
            (name == "auto" && !known.in_folder.empty() && folder_name.find(known.in_folder) != std::string::npos))
            return known;
    throw fresco::Error(folder.string() + ": unknown camera: the folder's name does not contain one; set option \"camera\" "
                                          "(freiburg1, freiburg2, freiburg3, ros_default) or \"intrinsics\", such as "
                                          "layout: {type: layout.tum, camera: freiburg3}");
}

void check_list(const std::vector<double>& list, std::size_t count, const std::string& option, const std::string& form)
{
    if (!list.empty() && list.size() != count)
        throw fresco::Error(fmt::format("option \"{}\": {} numbers; expected {}", option, list.size(), form));
    for (const double number : list)
        if (!std::isfinite(number))
            throw fresco::Error("option \"" + option + "\": a number is not finite");
}

}  // namespace

RecordingCamera recording_camera(std::string_view name, const std::vector<double>& intrinsics,
                                 const std::vector<double>& distortion, const std::filesystem::path& folder)
{
    check_list(intrinsics, 4, "intrinsics", "fx, fy, cx, cy");
    check_list(distortion, 5, "distortion", "k1, k2, p1, p2, k3");
    const auto camera_of = [](const auto& k, int width, int height)
    { return fresco::Intrinsics{width, height, k[0], k[1], k[2] + 0.5, k[3] + 0.5}; };
    const auto lens_of = [](const auto& d) { return Lens{.k1 = d[0], .k2 = d[1], .k3 = d[4], .p1 = d[2], .p2 = d[3]}; };

    RecordingCamera camera;
    if (!intrinsics.empty())
    {
        camera.intrinsics = camera_of(intrinsics, 0, 0);
        camera.source = "option intrinsics";
    }
    else
    {
        const auto& known = known_camera(name, folder);
        camera.intrinsics = camera_of(known.intrinsics, 640, 480);
        camera.lens = lens_of(known.distortion);
        camera.source = "the camera " + std::string(known.name);
    }
    if (!distortion.empty())
        camera.lens = lens_of(distortion);
    return camera;
}

}  // namespace tum
