#include "tum_camera.h"

#include <fresco/error.h>

#include <array>
#include <cmath>
#include <fmt/format.h>

namespace tum
{
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
                                          "(freiburg1, freiburg2, freiburg3, ros_default) or \"intrinsics\"");
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
    const auto lens_of = [](const auto& d)
    { return fresco::recordings::Lens{.k1 = d[0], .k2 = d[1], .k3 = d[4], .p1 = d[2], .p2 = d[3]}; };

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
