#include <fresco/recordings/recording_files.h>

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/recordings/text_records.h>

#include <array>
#include <fmt/format.h>
#include <map>

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

std::string expected_files(const std::vector<fs::path>& candidates, std::string_view option)
{
    std::string names;
    for (const auto& candidate : candidates)
        names += (names.empty() ? "" : " or ") + candidate.string();
    return fmt::format("{}, or set option \"{}\"", names, option);
}

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

}  // namespace fresco::recordings
