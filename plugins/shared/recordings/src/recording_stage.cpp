#include <fresco/recordings/recording_stage.h>

#include <fresco/error.h>
#include <fresco/mesh_io.h>
#include <fresco/recordings/picture_checks.h>

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace fresco::recordings
{
namespace
{

namespace fs = std::filesystem;

using PathOption = std::variant<Option<InputFolder>, Option<InputFile>>;

PathOption path_option(Configurable* owner, const RecordingHelp& help)
{
    if (!help.extensions.extensions.empty())
        return PathOption(std::in_place_type<Option<InputFile>>, owner, "path", required, help.extensions, help.path);
    return PathOption(std::in_place_type<Option<InputFolder>>, owner, "path", required, help.folder, help.path);
}

std::vector<RecordedView> every_nth(std::vector<RecordedView> views, int every, bool of_sequence)
{
    std::vector<RecordedView> chosen;
    int place = 0;
    for (std::size_t i = 0; i < views.size(); ++i)
    {
        if (of_sequence && i > 0 && views[i].sequence != views[i - 1].sequence)
            place = 0;
        if (place++ % every == 0)
            chosen.push_back(views[i]);
    }
    return chosen;
}

std::vector<fs::path> files_of(const RecordedView& view)
{
    std::vector<fs::path> files;
    for (const auto& file : {view.color, view.depth, view.mask, view.pose})
        if (!file.empty())
            files.push_back(file);
    return files;
}

void refuse_missing_files(const std::vector<RecordedView>& views, const std::string& files)
{
    std::vector<std::string> missing;
    std::string source;
    for (const auto& view : views)
        for (const auto& file : files_of(view))
            if (std::error_code ignored; !fs::is_regular_file(file, ignored))
            {
                if (missing.empty())
                    source = view.source;
                missing.push_back(file.string());
            }
    refuse_missing(missing, files.empty() ? source + (missing.size() == 1 ? " lists it" : " lists the first")
                                          : "each view needs " + files);
}

}  // namespace

RecordingStage::RecordingStage(const RecordingHelp& help)
    : path_(path_option(this, help)), every(this, "every", 1, range(1, 1'000'000), help.every),
      frames(this, "frames", help.frames)
{
}

bool RecordingStage::locate(RecordedView& /*view*/, RunContext& /*run*/)
{
    return true;
}

bool RecordingStage::unpack(RecordedView& /*view*/, const fs::path& /*folder*/) const
{
    return false;
}

const fs::path& RecordingStage::path() const
{
    return std::visit([](const auto& option) -> const fs::path& { return option->path; }, path_);
}

void RecordingStage::run(RunContext& run)
{
    auto recording = list(run);
    if (recording.views.empty())
        throw MissingInput(path().string() + ": the recording holds no views; each needs " + recording.files);
    auto chosen = every_nth(std::move(recording.views), *every, recording.every_of_sequence);
    refuse_missing_files(chosen, recording.files);
    std::vector<RecordedView> views;
    for (auto& view : chosen)
    {
        run.check_canceled();
        for (const auto& file : files_of(view))
            run.reads_file(file);
        if (locate(view, run))
            views.push_back(std::move(view));
    }
    const auto lost = chosen.size() - views.size();
    if (views.empty())
        throw Error(fmt::format("{}: none of the {} poses is finite: the recorder lost tracking; use another recording",
                                path().string(), chosen.size()));
    auto made = recorded_frames(views, *images, frames.folder().path, run,
                                [this](RecordedView& view, const fs::path& folder) { return unpack(view, folder); });

    const auto undistorted = std::ranges::count_if(views, [](const auto& view) { return view.lens.distorts(); });
    const auto masked = std::ranges::count_if(made.frames, [](const auto& frame) { return !frame.mask.empty(); });
    const bool has_depth = !made.frames.front().depth_picture.empty();
    run.report("frames", views.size());
    run.report("poses_not_tracked", lost);
    run.report("undistorted", undistorted);
    run.report("masked", masked);
    run.report("has_depth", has_depth);
    run.message(fmt::format("{} frames{}{}{}{}{}", views.size(), has_depth ? "" : " without depth",
                            undistorted > 0 ? fmt::format(", {} undistorted", undistorted) : "",
                            masked > 0 ? fmt::format(", {} with a mask", masked) : "",
                            lost > 0 ? fmt::format(", {} left out because their pose is not finite", lost) : "", recording.note));
    frames = std::move(made);
}

RecordedMesh::RecordedMesh(Configurable* owner, std::string option_help, std::string output_help)
    : file_(owner, "mesh", InputFile{}, formats({ply_format(), obj_format()}), std::move(option_help)),
      mesh_(owner, "mesh", optional, std::move(output_help))
{
}

void RecordedMesh::read(const std::vector<fs::path>& candidates, RunContext& run)
{
    const auto file = find_file(*file_, candidates, run);
    if (!file)
        return leave_out(expected_files(candidates, "mesh"), run);
    Mesh surface = read_mesh(*file);
    check_mesh(surface, file->string());
    mesh_ = std::move(surface);
    run.report("mesh", file->filename().string());
}

void RecordedMesh::leave_out(const std::string& expected, RunContext& run)
{
    run.warning("there is no mesh; expected " + expected + ". mesh.fuse makes one from the depth pictures");
}

RecordedMesh& RecordedMesh::operator=(Mesh surface)
{
    mesh_ = std::move(surface);
    return *this;
}

Option<double> depth_unit_option(Configurable* owner, double unit_m)
{
    return {owner, "depth_unit_m", unit_m, range(1e-6, 1.0), "Meters per step of the depth pictures"};
}

PixelCenterOption::PixelCenterOption(Configurable* owner, const std::string& word)
    : word_(owner, "pixel_center", word, one_of({"half", "integer"}),
            "Where the intrinsics put the center of the first pixel: at (0.5, 0.5) or at (0, 0)")
{
}

}  // namespace fresco::recordings
