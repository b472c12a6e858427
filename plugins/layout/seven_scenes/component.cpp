#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/run_context.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <ranges>
#include <string>
#include <vector>

namespace
{

namespace fs = std::filesystem;
using namespace fresco;
using namespace fresco::recordings;

/// How the two cameras of a recording see and where they are to each other.
struct Calibration
{
    CameraMatrix color;
    CameraMatrix depth;
    RigidTransform color_from_depth;
};

const char* const assumed = "assumed intrinsics";
constexpr int assumed_width = 640;
constexpr int assumed_height = 480;

/// Whether the file is there; if not, a warning says what is assumed.
bool is_there(const fs::path& file, const std::string& assumption, RunContext& run)
{
    if (fs::exists(file))
    {
        run.reads_file(file);
        return true;
    }
    looks_for(file, run);
    run.warning(file.filename().string() + " is missing: " + assumption);
    return false;
}

CameraMatrix matrix_of(const fs::path& file, RunContext& run)
{
    if (is_there(file, "focal length 585 and center (320, 240) are assumed", run))
        return {read_matrix_text(file, 3, 3), file.string()};
    return {{585, 0, 320, 0, 585, 240, 0, 0, 1}, assumed};
}

/// The three parts from their files in `path`, or the values that the makers of 7-Scenes name: focal length 585 and center
/// (320, 240) at 640x480 for both cameras, and one place for both; then a warning says so. Throws Error naming file and line.
Calibration read_calibration(const fs::path& path, RunContext& run)
{
    Calibration calibration{matrix_of(path / "color-intrinsics.txt", run), matrix_of(path / "depth-intrinsics.txt", run), {}};
    const auto file = path / "color_from_depth.txt";
    if (is_there(file, "the color camera is taken to be where the depth camera is", run))
        calibration.color_from_depth = read_rigid_transform(file);
    return calibration;
}

/// Intrinsics for pictures of this size, such as `picture`. Throws Error if the matrix was assumed and the size is not the one it
/// is for, and as intrinsics_for does.
Intrinsics calibrated(const CameraMatrix& matrix, const ImageHeader& size, const fs::path& picture)
{
    if (matrix.source == assumed && (size.width != assumed_width || size.height != assumed_height))
        throw Error(fmt::format("the pictures are {}x{}; the default calibration is for 640x480: put color-intrinsics.txt and "
                                "depth-intrinsics.txt into the scan's folder",
                                size.width, size.height));
    return intrinsics_for(matrix, PixelCenter::half, size, picture);
}

/// The folders `path`/seq-XX by number; only those in `wanted`, unless it is empty. A `path` without such folders that holds
/// frames itself is one sequence. Throws MissingInput if no sequence, or not every wanted one, exists; Error if two have one
/// number.
std::vector<fs::path> list_sequences(const fs::path& path, const std::vector<int>& wanted, RunContext& run)
{
    run.reads_folder(path, "seq-*");
    std::map<long, fs::path> found;
    for (const auto& entry : fs::directory_iterator(path))
        if (const auto number = number_after(entry.path().filename().string(), "seq-");
            number && entry.is_directory() && !found.emplace(*number, entry.path()).second)
            throw Error(fmt::format("{}: two folders for sequence {}; remove one", path.string(), *number));
    const auto is_pose = [](const fs::directory_entry& entry)
    {
        const std::string name = entry.path().filename().string();
        return name.starts_with("frame-") && name.ends_with(".pose.txt");
    };
    if (found.empty() && std::ranges::any_of(fs::directory_iterator(path), is_pose))
        return {path};
    if (found.empty())
        throw MissingInput(path.string() +
                           ": no sequences; expected folders seq-01, seq-02, … with frame-000000.color.png (or .jpg), "
                           "frame-000000.depth.png and frame-000000.pose.txt");
    for (const int number : wanted)
        if (!found.contains(number))
            throw MissingInput(
                fmt::format("{}: no sequence {}; found {}", path.string(), number, fmt::join(found | std::views::keys, ", ")));
    std::vector<fs::path> folders;
    for (const auto& [number, folder] : found)
        if (wanted.empty() || std::ranges::find(wanted, number) != wanted.end())
            folders.push_back(folder);
    return folders;
}

class SevenScenesLayout final : public Layout
{
  public:
    Marks marks() const override { return {.contains = {"seq-*|frame-*.pose.txt"}}; }

  private:
    Option<std::vector<int>> sequences{this, "sequences", std::vector<int>{}, range(0, 999'999),
                                       "Numbers of the sequences to read; empty: all"};
    Recording list(RunContext& run) override
    {
        const auto folders = list_sequences(path(), *sequences, run);
        Recording recording{.files = "seq-N/frame-N.color.png (or .jpg), .depth.png and .pose.txt",
                            .note = fmt::format(" of {} sequences", folders.size()),
                            .meshes = {path() / "mesh.ply"},
                            .every_of_sequence = true};
        for (const auto& folder : folders)
            for (auto& view : numbered_views({folder, "frame-", {".color.png", ".color.jpg", ".color.jpeg"}},
                                             {folder, "frame-", {".depth.png"}}, {folder, "frame-", {".pose.txt"}}, run))
            {
                view.sequence = folder == path() ? "seq-01" : folder.filename().string();
                recording.views.push_back(std::move(view));
            }
        calibration_ = read_calibration(path(), run);
        run.report("sequences", folders.size());
        return recording;
    }

    bool locate(RecordedView& view, RunContext& /*run*/) override
    {
        if (cameras_.color.width == 0)
            cameras_ = {calibrated(calibration_.color, codec().header(view.color), view.color),
                        calibrated(calibration_.depth, codec().header(view.depth), view.depth),
                        calibration_.color_from_depth.inverse()};
        view.source = view.pose.string();
        cameras_.place(view, read_rigid_transform(view.pose));
        return true;
    }

    Calibration calibration_;
    RecorderCameras cameras_;
};

}  // namespace

FRESCO_COMPONENT("layout.seven_scenes", SevenScenesLayout, Layout,
                 "7-Scenes: color, depth and pose files by frame, in folders seq-XX")
