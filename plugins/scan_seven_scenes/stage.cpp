#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/recordings/recording_stage.h>
#include <fresco/run_context.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <string>
#include <vector>

namespace seven_scenes
{
namespace
{

/// How the two cameras of a recording see and where they are to each other.
struct Calibration
{
    fresco::recordings::CameraMatrix color;
    fresco::recordings::CameraMatrix depth;
    fresco::RigidTransform color_from_depth;
};

/// What the pipeline gives in place of files; empty lists: not given.
struct CalibrationOptions
{
    std::vector<double> color_intrinsics;  ///< fx, fy, cx, cy
    std::vector<double> depth_intrinsics;  ///< fx, fy, cx, cy
    std::vector<double> color_from_depth;  ///< 16 numbers, row by row
};

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

/// Each of the three parts from the options, else from its file in `path` (color-intrinsics.txt, depth-intrinsics.txt,
/// color_from_depth.txt), else the values that the makers of 7-Scenes name: focal length 585 and center (320, 240) at 640x480 for
/// both, and one place for both cameras; then a warning says so. Throws Error naming the option or the file and line.
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

/// Intrinsics for pictures of this size, such as `picture`. Throws Error if the matrix was assumed and the size is not the one it
/// is for, and as fresco::recordings::intrinsics_for does.
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

/// The folders `path`/seq-XX by number; only those in `wanted`, unless it is empty. A `path` without such folders that holds
/// frames itself is one sequence. Throws MissingInput if no sequence, or not every wanted one, exists; Error if two have one
/// number.
std::vector<fs::path> list_sequences(const fs::path& path, const std::vector<int>& wanted, fresco::RunContext& run)
{
    run.reads_folder(path, "seq-*");
    std::map<long, fs::path> found;
    for (const auto& entry : fs::directory_iterator(path))
        if (const auto number = fresco::recordings::number_after(entry.path().filename().string(), "seq-");
            number && entry.is_directory() && !found.emplace(*number, entry.path()).second)
            throw fresco::Error(fmt::format("{}: two folders for sequence {}; remove one", path.string(), *number));
    const auto is_pose = [](const fs::directory_entry& entry)
    {
        const std::string name = entry.path().filename().string();
        return name.starts_with("frame-") && name.ends_with(".pose.txt");
    };
    if (found.empty() && std::ranges::any_of(fs::directory_iterator(path), is_pose))
        return {path};
    if (found.empty())
        throw fresco::MissingInput(path.string() +
                                   ": no sequences; expected folders seq-01, seq-02, … with frame-000000.color.png (or .jpg), "
                                   "frame-000000.depth.png and frame-000000.pose.txt");
    std::string numbers;
    for (const auto& [number, folder] : found)
        numbers += (numbers.empty() ? "" : ", ") + std::to_string(number);
    for (const int number : wanted)
        if (!found.contains(number))
            throw fresco::MissingInput(fmt::format("{}: no sequence {}; found {}", path.string(), number, numbers));
    std::vector<fs::path> folders;
    for (const auto& [number, folder] : found)
        if (wanted.empty() || std::ranges::find(wanted, number) != wanted.end())
            folders.push_back(folder);
    return folders;
}

}  // namespace
}  // namespace seven_scenes

namespace
{

using namespace fresco::recordings;

class ScanSevenScenes final : public RecordingStage
{
  public:
    ScanSevenScenes()
        : RecordingStage({.path = "Folder of the scan",
                          .frames = "The recorded views, each with a color and a depth camera",
                          .every = "Use every n-th frame of each sequence",
                          .folder = fresco::folder_with({"seq-*|frame-*.pose.txt"})})
    {
    }

  private:
    RecordedMesh mesh{this, "Mesh in the poses' world; empty: mesh.ply in path", "The scanned surface"};
    fresco::Option<std::vector<int>> sequences{this, "sequences", std::vector<int>{}, fresco::range(0, 999'999),
                                               "Numbers of the sequences to read; empty: all"};
    fresco::Option<std::vector<double>> color_k{
        this, "color_intrinsics", std::vector<double>{},
        "fx, fy, cx, cy of the color camera in pixels; empty: color-intrinsics.txt in path"};
    fresco::Option<std::vector<double>> depth_k{
        this, "depth_intrinsics", std::vector<double>{},
        "fx, fy, cx, cy of the depth camera in pixels; empty: depth-intrinsics.txt in path"};
    fresco::Option<std::vector<double>> color_from_depth{
        this, "color_from_depth", std::vector<double>{},
        "4x4 matrix M, X_color = M X_depth in meters: 16 numbers, row by row; empty: color_from_depth.txt in path"};
    PixelCenterOption pixel_center{this, "half"};
    fresco::Option<double> depth_unit_m = depth_unit_option(this);

    Recording list(fresco::RunContext& run) override
    {
        const auto folders = seven_scenes::list_sequences(path(), *sequences, run);
        Recording recording{.files = "seq-N/frame-N.color.png (or .jpg), .depth.png and .pose.txt",
                            .note = fmt::format(" of {} sequences", folders.size()),
                            .every_of_sequence = true};
        for (const auto& folder : folders)
            for (auto& view : numbered_views({folder, "frame-", {".color.png", ".color.jpg", ".color.jpeg"}},
                                             {folder, "frame-", {".depth.png"}}, {folder, "frame-", {".pose.txt"}}, run))
            {
                view.sequence = folder == path() ? "seq-01" : folder.filename().string();
                view.depth_unit_m = *depth_unit_m;
                recording.views.push_back(std::move(view));
            }
        calibration_ = seven_scenes::read_calibration(
            path(), {.color_intrinsics = *color_k, .depth_intrinsics = *depth_k, .color_from_depth = *color_from_depth}, run);
        mesh.read({path() / "mesh.ply"}, run);
        run.report("sequences", folders.size());
        return recording;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        if (cameras_.color.width == 0)
            cameras_ = {seven_scenes::calibrated(calibration_.color, *pixel_center, codec().header(view.color), view.color),
                        seven_scenes::calibrated(calibration_.depth, *pixel_center, codec().header(view.depth), view.depth),
                        calibration_.color_from_depth.inverse()};
        view.source = view.pose.string();
        cameras_.place(view, fresco::recordings::read_rigid_transform(view.pose));
        return true;
    }

    fresco::Cost cost() const override
    {
        return {
            .seconds = {.fixed = 0.1, .per = {{fresco::count::frames, 0.001}, {fresco::count::faces, 5e-7}}},
            .memory_mb = {.fixed = 20, .per = {{fresco::count::faces, 1e-4}}},
            .disk_mb = {.per = {{fresco::count::faces, 2.1e-5}}},
            .makes = {{fresco::count::frames, {.files = "path", .pattern = "seq-*/frame-*.pose.txt", .divided_by = {"every"}}},
                      {fresco::count::faces, {.files = "path", .pattern = "mesh.ply", .bytes_each = 21}},
                      {fresco::count::square_meters,
                       {.files = "path", .pattern = "mesh.ply", .bytes_each = fresco::count::scan_bytes_per_square_meter}}}};
    }

    seven_scenes::Calibration calibration_;
    RecorderCameras cameras_;
};

}  // namespace

FRESCO_STAGE("scan.seven_scenes", ScanSevenScenes, "Posed frames and mesh in the layout of 7-Scenes")
