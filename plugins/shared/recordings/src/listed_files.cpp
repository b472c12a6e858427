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

Found by_ending(const ListedFile& file)
{
    Found found;
    const fs::path name = file.folder / with_slashes(file.name);
    for (const char* ending : {".png", ".jpg", ".jpeg", ".webp", ".heic", ".avif"})
        for (const auto& candidate : {fs::path(name).replace_extension(ending), fs::path(name.string() + ending)})
            if (is_file(candidate))
                found.insert(candidate);
    return found;
}

Found by_case(const ListedFile& file)
{
    std::vector<fs::path> places{file.folder};
    for (const auto& part : fs::path(with_slashes(file.name)))
    {
        std::vector<fs::path> next;
        for (const auto& place : places)
        {
            if (part == "." || part == ".." || part == "/")
                next.push_back(place / part);
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

Found by_last_parts(const ListedFile& file, const fs::path& recording)
{
    const fs::path name = with_slashes(file.name);
    for (auto first = name.begin(); first != name.end(); ++first)
    {
        fs::path rest;
        for (auto part = first; part != name.end(); ++part)
            rest /= *part;
        Found found;
        for (const auto& folder : {recording, file.folder})
            if (rest.is_relative() && is_file(folder / rest))
                found.insert(fs::canonical(folder / rest));
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
    const std::array<std::pair<const char*, std::function<Found(const ListedFile&)>>, 4> rules{
        {{"with / for \\",
          [](const ListedFile& file)
          {
              const auto path = file.folder / with_slashes(file.name);
              return is_file(path) ? Found{path} : Found{};
          }},
         {"with another ending", by_ending},
         {"with another case", by_case},
         {"by the last parts of their paths", [&](const ListedFile& file) { return by_last_parts(file, recording); }}}};
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
            *file->to = *found.begin();
            looks_for(file->to->parent_path() / "*", run);
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
