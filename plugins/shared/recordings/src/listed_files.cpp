#include <fresco/error.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fmt/format.h>
#include <functional>
#include <set>

namespace fresco::recordings
{
namespace
{

namespace fs = std::filesystem;

bool is_file(const fs::path& file)
{
    std::error_code ignored;
    return fs::is_regular_file(file, ignored);
}

std::string lower(std::string text)
{
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string with_slashes(std::string name)
{
    std::ranges::replace(name, '\\', '/');
    return name;
}

/// The files that a rule finds for a name; several paths to one file count once.
using Found = std::set<fs::path>;

Found by_slashes(const ListedFile& file, RunContext& run)
{
    const auto path = file.folder / with_slashes(file.name);
    looks_for(path, run);
    return is_file(path) ? Found{path} : Found{};
}

Found by_ending(const ListedFile& file, RunContext& run)
{
    constexpr std::array endings{".png", ".jpg", ".jpeg", ".webp", ".heic", ".avif"};
    fs::path name = file.folder / with_slashes(file.name);
    if (std::ranges::find(endings, name.extension()) != endings.end())
        name.replace_extension();
    const bool is_named_without = !fs::path(with_slashes(file.name)).has_extension();
    Found found;
    for (const char* ending : endings)
    {
        const fs::path candidate = name.string() + ending;
        looks_for(candidate, run);
        if (is_file(candidate))
            found.insert(candidate);
        // Synthetic scenes name PNG pictures without their ending.
        if (is_named_without && !found.empty() && candidate.extension() == ".png")
            return found;
    }
    return found;
}

Found by_case(const ListedFile& file, RunContext& run)
{
    std::vector<fs::path> places{file.folder};
    for (const auto& part : fs::path(with_slashes(file.name)))
    {
        std::vector<fs::path> next;
        for (const auto& place : places)
        {
            if (part == "." || part == ".." || part == "/")
            {
                next.push_back(place / part);
                continue;
            }
            looks_for(place / "*", run);
            std::error_code missing;
            for (const auto& entry : fs::directory_iterator(place, missing))
                if (lower(entry.path().filename().string()) == lower(part.string()))
                    next.push_back(entry.path());
        }
        places = std::move(next);
    }
    Found found;
    std::ranges::copy_if(places, std::inserter(found, found.end()), is_file);
    return found;
}

Found by_last_parts(const ListedFile& file, const fs::path& recording, RunContext& run)
{
    const fs::path name = with_slashes(file.name);
    for (auto first = name.begin(); first != name.end(); ++first)
    {
        fs::path rest;
        for (auto part = first; part != name.end(); ++part)
            rest /= *part;
        if (rest.is_absolute())
            continue;
        Found found;
        for (const auto& folder : {recording, file.folder})
        {
            looks_for(folder / rest, run);
            std::error_code ignored;
            const auto is_same = [&](const fs::path& other) { return fs::equivalent(other, folder / rest, ignored); };
            if (is_file(folder / rest) && std::ranges::none_of(found, is_same))
                found.insert(folder / rest);
        }
        if (!found.empty())
            return found;
    }
    return {};
}

}  // namespace

void find_listed_files(const std::vector<ListedFile>& files, const fs::path& recording, RunContext& run)
{
    std::vector<const ListedFile*> missing;
    for (const auto& file : files)
    {
        *file.to = file.folder / file.name;
        if (!is_file(*file.to))
            missing.push_back(&file);
    }
    if (missing.empty())
        return;
    using Rule = std::function<Found(const ListedFile&)>;
    const auto with_run = [&](Found (*find)(const ListedFile&, RunContext&)) -> Rule
    { return [&run, find](const ListedFile& file) { return find(file, run); }; };
    const std::array<std::pair<const char*, Rule>, 4> rules{
        {{"with / for \\", with_run(by_slashes)},
         {"with another ending", with_run(by_ending)},
         {"with another case", with_run(by_case)},
         {"by the last parts of their paths", [&](const ListedFile& file) { return by_last_parts(file, recording, run); }}}};
    for (const auto* file : missing)
        looks_for(*file->to, run);
    for (const auto& [words, rule] : rules)
    {
        std::size_t count = 0;
        for (const auto* file : missing)
        {
            const Found found = rule(*file);
            if (found.size() > 1)
                throw Error(fmt::format(
                    "{} is not there, and two files could be meant, {} and {}: remove one, or correct the name",
                    (file->folder / file->name).string(), found.begin()->string(), std::next(found.begin())->string()));
            if (found.empty())
                continue;
            const auto is_taken = [&](const ListedFile& other) { return &other != file && *other.to == *found.begin(); };
            if (const auto other = std::ranges::find_if(files, is_taken); other != files.end())
                throw Error(fmt::format("{} is not there; {} could be meant, but that is {} already: correct the names",
                                        (file->folder / file->name).string(), found.begin()->string(), other->name));
            *file->to = *found.begin();
            ++count;
        }
        if (count > 0)
        {
            run.message(fmt::format("{} of {} files were not where the recording names them; {} were found {}, such as {}",
                                    missing.size(), files.size(), count, words, missing.front()->to->string()));
            return;
        }
    }
}

bool is_system_file(const fs::path& file)
{
    const std::string name = file.filename().string();
    return name.starts_with("._") || name == ".DS_Store" || name == "Thumbs.db" || name == "desktop.ini" || name == "@eaDir";
}

}  // namespace fresco::recordings
