#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/numerics/numerics.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>

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

void forget_missing_depth(std::vector<RecordedView>& views)
{
    const auto has_depth = [](const RecordedView& view) { return fs::exists(view.depth); };
    if (std::ranges::any_of(views, has_depth))
        for (auto& view : views)
            if (!has_depth(view))
                view.depth.clear();
}

void looks_for(const fs::path& pattern, RunContext& run)
{
    auto name = pattern;
    std::error_code ignored;
    while (name.parent_path().has_relative_path() && !fs::is_directory(name.parent_path(), ignored))
        name = name.parent_path();
    run.reads_folder(name.parent_path(), name.filename().string());
}

namespace
{

/// The files that a candidate stands for: itself, or those that end as it does behind a '*'.
std::vector<fs::path> files_like(const fs::path& candidate)
{
    const std::string name = candidate.filename().string();
    if (!name.starts_with('*'))
        return fs::is_regular_file(candidate) ? std::vector{candidate} : std::vector<fs::path>{};
    std::vector<fs::path> files;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(candidate.parent_path(), missing))
        if (entry.is_regular_file() && entry.path().filename().string().ends_with(name.substr(1)) &&
            !is_system_file(entry.path()))
            files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

/// The first of `candidates` that is there. Throws Error if several files are like it.
std::optional<fs::path> find_file(const std::vector<fs::path>& candidates, RunContext& run)
{
    for (const auto& candidate : candidates)
    {
        const auto files = files_like(candidate);
        if (files.empty() || files.front() != candidate)
            looks_for(candidate, run);
        if (files.size() > 1)
            throw Error(fmt::format("{}: several meshes, {} and {}; choose one with option \"mesh\"",
                                    candidate.parent_path().string(), files[0].filename().string(),
                                    files[1].filename().string()));
        if (files.empty())
            continue;
        run.reads_file(files.front());
        return files.front();
    }
    return std::nullopt;
}

std::string joined(const std::vector<fs::path>& candidates)
{
    const auto name = [](const fs::path& file) { return file.string(); };
    return fmt::format("{}", fmt::join(candidates | std::views::transform(name), " or "));
}

}  // namespace

fs::path first_file(const std::vector<fs::path>& candidates, std::string_view what, RunContext& run)
{
    if (auto file = find_file(candidates, run))
        return *file;
    throw MissingInput(std::string(what) + " is missing; expected " + joined(candidates));
}

std::string doubts_about_size(Vec3d extent, double unit_m)
{
    // No thing to paint is smaller than the first in all directions; no building is larger than the others in one, two and three.
    constexpr double least = 0.3, longest = 300, widest = 100, highest = 30;
    constexpr double least_guessed = 1, most_guessed = 50;
    std::array sides{extent.x, extent.y, extent.z};
    std::ranges::sort(sides);
    if (sides[2] >= least && sides[2] <= longest && sides[1] <= widest && sides[0] <= highest)
        return "";
    std::string units;
    for (const auto& [name, meter] :
         {std::pair{"meters", 1.0}, {"feet", 0.3048}, {"inches", 0.0254}, {"centimeters", 0.01}, {"millimeters", 0.001}})
        if (const double size = sides[2] / unit_m * meter; size >= least_guessed && size <= most_guessed)
            units += fmt::format("{}{:g} if it is in {} ({:.3g} m long)", units.empty() ? ": " : ", ", meter, name, size);
    return fmt::format("the mesh is {:.4g} x {:.4g} x {:.4g} m; set unit_m, the meters per unit of the file{}", extent.x,
                       extent.y, extent.z, units);
}

std::string recorded_text(const fs::path& file, RunContext& run)
{
    run.reads_file(file);
    return read_text_file(file);
}

namespace
{

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

std::optional<Mesh> read_recorded_mesh(const InputFile& given, const std::vector<fs::path>& candidates, Vec3d offset_m,
                                       RunContext& run)
{
    const auto file = given.empty() ? find_file(candidates, run) : given.path;
    if (!file)
    {
        if (!candidates.empty())
            run.warning("there is no mesh; expected " + joined(candidates) +
                        ", or set option \"mesh\". mesh.fuse makes one from the depth pictures");
        return std::nullopt;
    }
    MeshReadReport report;
    Mesh surface = read_mesh(*file, {}, &report);
    try
    {
        place(surface, report.positions, offset_beside(offset_m, report.positions, file->string()));
    }
    catch (const Error& error)
    {
        // A mesh that nobody asked for is left out.
        if (!given.empty())
            throw;
        run.warning(error.what());
        return std::nullopt;
    }
    check_mesh(surface, file->string());
    numerics::Bounds<float> box;
    std::ranges::for_each(surface.positions, [&](Vec3f p) { box.add(p); });
    if (const auto doubts = doubts_about_size(vec_cast<double>(box.high - box.low)); !doubts.empty())
        run.warning(doubts + ": read it by scan.mesh with that option, and scale the poses by that of scan.recording");
    run.report("mesh", file->filename().string());
    return surface;
}

/// In meters, by what the user says of the recording.
void apply_units(RecordedView& view, const ReadingOptions& options)
{
    view.world_from_camera.translation = view.world_from_camera.translation * options.unit_m;
    if (view.depth_camera)
        view.depth_camera->world_from_camera.translation = view.depth_camera->world_from_camera.translation * options.unit_m;
    if (options.depth_unit_m > 0)
        view.depth_unit_m = options.depth_unit_m;
}

/// Moves the cameras by the offset that they need.
Vec3d take_offset(std::vector<RecordedView>& views)
{
    std::vector<Vec3d> places;
    for (const auto& view : views)
        places.push_back(view.world_from_camera.translation);
    const Vec3d offset_m = offset_for(places);
    for (auto& view : views)
    {
        view.world_from_camera.translation += -offset_m;
        if (view.depth_camera)
            view.depth_camera->world_from_camera.translation += -offset_m;
    }
    return offset_m;
}

}  // namespace

Layout::~Layout() = default;

bool Layout::locate(RecordedView& /*view*/, RunContext& /*run*/)
{
    return true;
}

bool Layout::unpack(RecordedView& /*view*/, const fs::path& /*folder*/) const
{
    return false;
}

ReadRecording read_recording(Layout& layout, const ReadingOptions& options, const ImageIo& images, const fs::path& folder,
                             RunContext& run)
{
    layout.path_ = options.path;
    layout.codec_ = &images;
    auto recording = layout.list(run);
    if (recording.views.empty())
        throw MissingInput(options.path.string() + ": the recording holds no views; each needs " + recording.files);
    auto chosen = every_nth(std::move(recording.views), options.every, recording.every_of_sequence);
    refuse_missing_files(chosen, recording.files);
    std::vector<RecordedView> views;
    for (auto& view : chosen)
    {
        run.check_canceled();
        for (const auto& file : files_of(view))
            run.reads_file(file);
        if (!layout.locate(view, run))
            continue;
        apply_units(view, options);
        views.push_back(std::move(view));
    }
    const auto lost = chosen.size() - views.size();
    if (views.empty())
        throw Error(fmt::format("{}: none of the {} poses is finite: the recorder lost tracking; use another recording",
                                options.path.string(), chosen.size()));
    const Vec3d offset_m = take_offset(views);
    tell_offset(offset_m, run);
    auto mesh = read_recorded_mesh(options.mesh, recording.meshes, offset_m, run);
    std::size_t transparent = 0;
    auto made = recorded_frames(
        views, images, folder, run, [&](RecordedView& view, const fs::path& into) { return layout.unpack(view, into); },
        &transparent);
    made.offset_m = offset_m;

    const auto panoramas = std::ranges::count_if(views, &RecordedView::is_panorama);
    const auto undistorted = std::ranges::count_if(views, [](const auto& view) { return view.lens.distorts(); });
    const auto masked = std::ranges::count_if(made.frames, [](const auto& frame) { return !frame.mask.empty(); });
    const auto without_depth = std::ranges::count_if(made.frames, [](const auto& frame) { return frame.depth_picture.empty(); });
    const bool has_depth = without_depth < std::ssize(made.frames);
    run.report("frames", made.frames.size());
    run.report("panoramas", panoramas);
    run.report("poses_not_tracked", lost);
    run.report("undistorted", undistorted);
    run.report("masked", masked);
    run.report("transparent", transparent);
    run.report("has_depth", has_depth);
    run.message(fmt::format("{} frames{}{}{}{}{}{}{}", made.frames.size(),
                            !has_depth          ? " without depth"
                            : without_depth > 0 ? fmt::format(", {} of them without depth", without_depth)
                                                : "",
                            panoramas > 0 ? fmt::format(", cut from {} 360° pictures", panoramas) : "",
                            undistorted > 0 ? fmt::format(", {} undistorted", undistorted) : "",
                            masked > 0 ? fmt::format(", {} with a mask", masked) : "",
                            transparent > 0 ? fmt::format(", {} pictures with transparent pixels", transparent) : "",
                            lost > 0 ? fmt::format(", {} left out because their pose is not finite", lost) : "", recording.note));
    return {std::move(made), std::move(mesh)};
}

Choice<PixelCenter> pixel_center_option(Configurable* owner, PixelCenter value)
{
    return {owner,
            "pixel_center",
            value,
            {{"half", PixelCenter::half}, {"integer", PixelCenter::integer}},
            "Where the intrinsics put the center of the first pixel: at (0.5, 0.5) or at (0, 0)"};
}

}  // namespace fresco::recordings
