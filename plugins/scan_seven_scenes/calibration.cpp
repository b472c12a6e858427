#include "calibration.h"

#include <fresco/error.h>

namespace fs = std::filesystem;

namespace
{

const char* const assumed = "assumed intrinsics";
constexpr int assumed_width = 640;
constexpr int assumed_height = 480;
const std::vector<double> assumed_matrix{585, 0, 320, 0, 585, 240, 0, 0, 1};

struct NamedMatrix
{
    std::vector<double> values;
    std::string source;
};

NamedMatrix intrinsics_part(const std::vector<double>& option, const std::string& option_name, const fs::path& file,
                            Calibration& calibration)
{
    if (!option.empty())
    {
        if (option.size() != 4)
            throw fresco::Error("option " + option_name + ": " + std::to_string(option.size()) +
                                " numbers where fx, fy, cx, cy were expected");
        return {{option[0], 0, option[2], 0, option[1], option[3], 0, 0, 1}, "option " + option_name};
    }
    if (fs::exists(file))
    {
        calibration.files.push_back(file);
        return {fresco::read_matrix_text(file, 3, 3), file.string()};
    }
    calibration.missing.push_back(file.filename().string());
    calibration.guesses.push_back(calibration.missing.back() + " is missing and the option " + option_name +
                                  " is not given: focal length 585 and center (320, 240) are assumed");
    return {assumed_matrix, assumed};
}

fresco::RigidTransform transform_part(const std::vector<double>& option, const fs::path& file, Calibration& calibration)
{
    if (!option.empty())
        return fresco::rigid_transform(option, "option color_from_depth");
    if (fs::exists(file))
    {
        calibration.files.push_back(file);
        return fresco::read_rigid_transform(file);
    }
    calibration.missing.push_back(file.filename().string());
    calibration.guesses.push_back(calibration.missing.back() +
                                  " is missing and the option color_from_depth is not given: the color "
                                  "camera is taken to be where the depth camera is");
    return {};
}

fresco::Intrinsics intrinsics_for(const std::vector<double>& matrix, const std::string& source, fresco::PixelCenter center,
                                  int width, int height)
{
    if (source == assumed && (width != assumed_width || height != assumed_height))
        throw fresco::Error("the pictures are " + std::to_string(width) + "x" + std::to_string(height) +
                            ", and without a calibration only 640x480 can be assumed: give color-intrinsics.txt and "
                            "depth-intrinsics.txt in the scan's folder, or the options color_intrinsics and depth_intrinsics");
    return fresco::intrinsics_from_matrix(matrix, source == assumed ? fresco::PixelCenter::half : center, width, height, source);
}

}  // namespace

Calibration read_calibration(const fs::path& path, const CalibrationOptions& options)
{
    Calibration calibration;
    calibration.center = options.center;
    auto color = intrinsics_part(options.color_intrinsics, "color_intrinsics", path / "color-intrinsics.txt", calibration);
    auto depth = intrinsics_part(options.depth_intrinsics, "depth_intrinsics", path / "depth-intrinsics.txt", calibration);
    calibration.color_matrix = std::move(color.values);
    calibration.color_source = std::move(color.source);
    calibration.depth_matrix = std::move(depth.values);
    calibration.depth_source = std::move(depth.source);
    calibration.color_from_depth = transform_part(options.color_from_depth, path / "color_from_depth.txt", calibration);
    return calibration;
}

fresco::Intrinsics color_intrinsics(const Calibration& calibration, int width, int height)
{
    return intrinsics_for(calibration.color_matrix, calibration.color_source, calibration.center, width, height);
}

fresco::Intrinsics depth_intrinsics(const Calibration& calibration, int width, int height)
{
    return intrinsics_for(calibration.depth_matrix, calibration.depth_source, calibration.center, width, height);
}
