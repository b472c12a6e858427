#include "calibration.h"

#include <fresco/error.h>
#include <fresco/recordings/recording_stage.h>

#include <fmt/format.h>

namespace seven_scenes
{
namespace
{

namespace fs = std::filesystem;
using fresco::recordings::CameraMatrix;

const char* const assumed = "assumed intrinsics";
constexpr int assumed_width = 640;
constexpr int assumed_height = 480;

/// Whether the file is there; if not, a warning says what is assumed.
bool is_there(const fs::path& file, const std::string& option, const std::string& assumption, fresco::RunContext& run)
{
    if (fs::exists(file))
    {
        run.reads_file(file);
        return true;
    }
    fresco::recordings::looks_for(file, run);
    run.warning(file.filename().string() + " is missing and option \"" + option + "\" is not set: " + assumption);
    return false;
}

CameraMatrix matrix_of(const std::vector<double>& values, const std::string& option, const fs::path& file,
                       fresco::RunContext& run)
{
    if (!values.empty() && values.size() != 4)
        throw fresco::Error(fmt::format("option \"{}\": {} numbers; expected fx, fy, cx, cy", option, values.size()));
    if (!values.empty())
        return {{values[0], 0, values[2], 0, values[1], values[3], 0, 0, 1}, "option " + option};
    if (is_there(file, option, "focal length 585 and center (320, 240) are assumed", run))
        return {fresco::recordings::read_matrix_text(file, 3, 3), file.string()};
    return {{585, 0, 320, 0, 585, 240, 0, 0, 1}, assumed};
}

}  // namespace

Calibration read_calibration(const fs::path& path, const CalibrationOptions& options, fresco::RunContext& run)
{
    Calibration calibration{matrix_of(options.color_intrinsics, "color_intrinsics", path / "color-intrinsics.txt", run),
                            matrix_of(options.depth_intrinsics, "depth_intrinsics", path / "depth-intrinsics.txt", run),
                            {}};
    const auto file = path / "color_from_depth.txt";
    if (!options.color_from_depth.empty())
        calibration.color_from_depth = fresco::recordings::rigid_transform(options.color_from_depth, "option color_from_depth");
    else if (is_there(file, "color_from_depth", "the color camera is taken to be where the depth camera is", run))
        calibration.color_from_depth = fresco::recordings::read_rigid_transform(file);
    return calibration;
}

fresco::Intrinsics calibrated(const CameraMatrix& matrix, fresco::recordings::PixelCenter center, const fresco::ImageHeader& size,
                              const fs::path& picture)
{
    const bool is_assumed = matrix.source == assumed;
    if (is_assumed && (size.width != assumed_width || size.height != assumed_height))
        throw fresco::Error(
            fmt::format("the pictures are {}x{}; the default calibration is for 640x480: put color-intrinsics.txt and "
                        "depth-intrinsics.txt into the scan's folder, or set color_intrinsics and depth_intrinsics",
                        size.width, size.height));
    return fresco::recordings::intrinsics_for(matrix, is_assumed ? fresco::recordings::PixelCenter::half : center, size, picture);
}

}  // namespace seven_scenes
