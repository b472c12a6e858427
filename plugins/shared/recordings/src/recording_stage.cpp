#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/recordings/recording_stage.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <map>
#include <ranges>
#include <utility>

namespace fresco::recordings
{

namespace
{

namespace fs = std::filesystem;

struct NumberedFile
{
    fs::path path;
    std::string digits;
};

std::map<long, NumberedFile> files_by_number(const NumberedFiles& kind, RunContext& run)
{
    for (const auto& ending : kind.endings)
        looks_for(kind.folder / (kind.prefix + "*" + ending), run);
    std::map<long, NumberedFile> files;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(kind.folder, missing))
    {
        const auto name = entry.path().filename().string();
        for (const auto& ending : kind.endings)
        {
            if (!name.ends_with(ending))
                continue;
            const auto stem = name.substr(0, name.size() - ending.size());
            const auto number = number_after(stem, kind.prefix);
            if (!number || !entry.is_regular_file())
                continue;
            const auto [other, is_new] = files.try_emplace(*number, NumberedFile{entry.path(), stem.substr(kind.prefix.size())});
            if (!is_new)
                throw Error(entry.path().string() + ": a second file with this number, " +
                            other->second.path.filename().string() + "; remove one");
        }
    }
    return files;
}

}  // namespace

std::vector<RecordedView> numbered_views(const NumberedFiles& color, const NumberedFiles& depth, const NumberedFiles& pose,
                                         RunContext& run)
{
    const std::array<std::pair<const NumberedFiles&, fs::path RecordedView::*>, 3> kinds{
        {{color, &RecordedView::color}, {depth, &RecordedView::depth}, {pose, &RecordedView::pose}}};
    std::map<long, RecordedView> views;
    for (const auto& [kind, place] : kinds)
        for (const auto& [number, file] : files_by_number(kind, run))
        {
            auto& view = views[number];
            view.number = number;
            view.*place = file.path;
            if (view.name.empty())
                view.name = color.prefix + file.digits;
            else if (kind.folder == color.folder && kind.prefix == color.prefix && view.name != kind.prefix + file.digits)
                throw Error(
                    fmt::format("{}: a second name for number {}, the first is {}", file.path.string(), number, view.name));
        }
    std::vector<RecordedView> list;
    for (auto& [number, view] : views)
    {
        for (const auto& [kind, place] : kinds)
            if ((view.*place).empty() && !kind.endings.empty())
                view.*place = kind.folder / (kind.prefix + view.name.substr(color.prefix.size()) + kind.endings.front());
        list.push_back(std::move(view));
    }
    return list;
}

void looks_for(const fs::path& pattern, RunContext& run)
{
    auto name = pattern;
    while (name.parent_path().has_relative_path() && !fs::is_directory(name.parent_path()))
        name = name.parent_path();
    run.reads_folder(name.parent_path(), name.filename().string());
}

namespace
{

/// The file that an option gives, else the first of `candidates` that is there; else none.
std::optional<fs::path> find_file(const InputFile& given, const std::vector<fs::path>& candidates, RunContext& run)
{
    if (!given.empty())
        return given.path;
    for (const auto& candidate : candidates)
    {
        if (fs::is_regular_file(candidate))
        {
            run.reads_file(candidate);
            return candidate;
        }
        looks_for(candidate, run);
    }
    return std::nullopt;
}

/// FILE or FILE, or set option "OPTION".
std::string expected_files(const std::vector<fs::path>& candidates, std::string_view option)
{
    const auto name = [](const fs::path& file) { return file.string(); };
    return fmt::format("{}, or set option \"{}\"", fmt::join(candidates | std::views::transform(name), " or "), option);
}

}  // namespace

fs::path first_file(const InputFile& given, const std::vector<fs::path>& candidates, std::string_view what,
                    std::string_view option, RunContext& run)
{
    if (auto file = find_file(given, candidates, run))
        return *file;
    throw MissingInput(std::string(what) + " is missing; expected " + expected_files(candidates, option));
}

std::string recorded_text(const fs::path& file, RunContext& run)
{
    run.reads_file(file);
    return read_text_file(file);
}

namespace
{

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
    constexpr std::size_t most_named = 5;
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
    if (missing.empty())
        return;
    const bool is_one = missing.size() == 1;
    const auto named = std::span(missing).first(std::min(missing.size(), most_named));
    throw MissingInput(
        fmt::format("{} {} missing: {}{}; {}", missing.size(), is_one ? "file is" : "files are", fmt::join(named, ", "),
                    missing.size() > most_named ? ", …" : "",
                    files.empty() ? source + (is_one ? " lists it" : " lists the first") : "each view needs " + files));
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
    std::size_t transparent = 0;
    auto made = recorded_frames(
        views, *images, frames.folder().path, run,
        [this](RecordedView& view, const fs::path& folder) { return unpack(view, folder); }, &transparent);

    const auto panoramas = std::ranges::count_if(views, &RecordedView::is_panorama);
    const auto undistorted = std::ranges::count_if(views, [](const auto& view) { return view.lens.distorts(); });
    const auto masked = std::ranges::count_if(made.frames, [](const auto& frame) { return !frame.mask.empty(); });
    const bool has_depth = !made.frames.front().depth_picture.empty();
    run.report("frames", made.frames.size());
    run.report("panoramas", panoramas);
    run.report("poses_not_tracked", lost);
    run.report("undistorted", undistorted);
    run.report("masked", masked);
    run.report("transparent", transparent);
    run.report("has_depth", has_depth);
    run.message(fmt::format("{} frames{}{}{}{}{}{}{}", made.frames.size(), has_depth ? "" : " without depth",
                            panoramas > 0 ? fmt::format(", cut from {} 360° pictures", panoramas) : "",
                            undistorted > 0 ? fmt::format(", {} undistorted", undistorted) : "",
                            masked > 0 ? fmt::format(", {} with a mask", masked) : "",
                            transparent > 0 ? fmt::format(", {} pictures with transparent pixels", transparent) : "",
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
