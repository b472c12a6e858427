#include <fresco/error.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <map>
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

std::string with_slashes(std::string name)
{
    std::ranges::replace(name, '\\', '/');
    return name;
}

/// The files that a rule finds for a name; several paths to one file count once.
using Found = std::set<fs::path>;

/// Finds files and says what it looks for.
class Search
{
  public:
    Search(const fs::path& recording, const LooksFor& looks_for) : recording_(recording), looks_for_(looks_for) {}

    Found by_slashes(const ListedFile& file)
    {
        const auto path = file.folder / with_slashes(file.name);
        looks_for_(path);
        return is_file(path) ? Found{path} : Found{};
    }

    Found by_ending(const ListedFile& file)
    {
        constexpr std::array endings{".png", ".jpg", ".jpeg", ".webp", ".heic", ".avif"};
        if (!file.any_ending)
            return {};
        fs::path name = file.folder / with_slashes(file.name);
        if (std::ranges::find(endings, name.extension()) != endings.end())
            name.replace_extension();
        const bool is_named_without = !fs::path(with_slashes(file.name)).has_extension();
        Found found;
        for (const char* ending : endings)
        {
            const fs::path candidate = name.string() + ending;
            looks_for_(candidate);
            if (is_file(candidate))
                found.insert(candidate);
            // Synthetic scenes name PNG pictures without their ending.
            if (is_named_without && !found.empty() && candidate.extension() == ".png")
                return found;
        }
        return found;
    }

    Found by_case(const ListedFile& file) { return in_any_case(file.folder, with_slashes(file.name)); }

    Found by_last_parts(const ListedFile& file)
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
            const auto add = [&](const fs::path& candidate)
            {
                std::error_code ignored;
                const auto is_same = [&](const fs::path& other) { return fs::equivalent(other, candidate, ignored); };
                if (is_file(candidate) && std::ranges::none_of(found, is_same))
                    found.insert(candidate);
            };
            const std::array folders{recording_, file.folder};
            for (const auto& folder : folders)
            {
                looks_for_(folder / rest);
                add(folder / rest);
            }
            for (const auto& folder : folders)
                if (found.empty())
                    std::ranges::for_each(in_any_case(folder, rest), add);
            if (!found.empty())
                return found;
        }
        return {};
    }

  private:
    const std::multimap<std::string, fs::path>& listing(const fs::path& folder)
    {
        const auto [found, is_new] = listed_.try_emplace(folder);
        std::error_code missing;
        if (is_new)
            for (const auto& entry : fs::directory_iterator(folder, missing))
                found->second.emplace(lower_case(entry.path().filename().string()), entry.path());
        return found->second;
    }

    /// The files at `name` below the folder, in any case.
    Found in_any_case(const fs::path& folder, const fs::path& name)
    {
        std::vector<fs::path> places{folder};
        for (const auto& part : name)
        {
            std::string names = part.string();
            std::ranges::replace_if(
                names, [](unsigned char c) { return std::isalpha(c) != 0; }, '?');
            std::vector<fs::path> next;
            for (const auto& place : places)
            {
                if (part == "." || part == ".." || part == "/")
                {
                    next.push_back(place / part);
                    continue;
                }
                looks_for_(place / names);
                const auto [first, last] = listing(place).equal_range(lower_case(part.string()));
                for (auto entry = first; entry != last; ++entry)
                    next.push_back(entry->second);
            }
            places = std::move(next);
        }
        Found found;
        std::ranges::copy_if(places, std::inserter(found, found.end()), is_file);
        return found;
    }

    const fs::path& recording_;
    const LooksFor& looks_for_;
    std::map<fs::path, std::multimap<std::string, fs::path>> listed_;  ///< Files of a folder by their names in lower case.
};

}  // namespace

void find_listed_files(const std::vector<ListedFile>& files, const fs::path& recording, RunContext& run)
{
    const std::string found = find_listed_files(files, recording, [&](const fs::path& pattern) { looks_for(pattern, run); });
    if (!found.empty())
        run.message(found);
}

std::string find_listed_files(const std::vector<ListedFile>& files, const fs::path& recording, const LooksFor& looks_for)
{
    std::vector<const ListedFile*> missing;
    for (const auto& file : files)
    {
        *file.to = file.folder / file.name;
        if (!is_file(*file.to))
            missing.push_back(&file);
    }
    if (missing.empty())
        return "";
    Search search(recording, looks_for);
    using Rule = Found (Search::*)(const ListedFile&);
    const std::array<std::pair<const char*, Rule>, 4> rules{{{"with / for \\", &Search::by_slashes},
                                                             {"with another ending", &Search::by_ending},
                                                             {"with another case", &Search::by_case},
                                                             {"by the last parts of their paths", &Search::by_last_parts}}};
    for (const auto* file : missing)
        looks_for(*file->to);
    for (const auto& [words, rule] : rules)
    {
        std::size_t count = 0;
        for (const auto* file : missing)
        {
            const Found found = (search.*rule)(*file);
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
        if (count > 0 && files.size() == 1)
            return fmt::format("\"{}\" was found {}: {}", files[0].name, words, files[0].to->string());
        if (count > 0)
            return fmt::format("{} of {} files were not where the recording names them; {} were found {}, such as {}",
                               missing.size(), files.size(), count, words, missing.front()->to->string());
    }
    return "";
}

namespace
{

/// The part of a name that can be below a folder: the name, or what follows a drive, a scheme, the root and the last "..".
std::string part_below(std::string_view name)
{
    std::string text(name);
    std::ranges::replace(text, '\\', '/');
    const auto colon = text.find(':');
    const bool has_scheme = colon != std::string::npos && colon > 0 && text.find_first_of("/ .") > colon &&
                            (colon == 1 || text.substr(colon + 1, 1) == "/");
    const fs::path path = fs::path(has_scheme ? text.substr(colon + 1) : text).lexically_normal();
    if (!has_scheme && path.is_relative() && text.find("..") == std::string::npos)
        return std::string(name);
    fs::path below;
    for (const auto& part : path.relative_path())
        if (part != "..")
            below /= part;
    return below.string();
}

bool is_inside(const fs::path& file, const fs::path& folder)
{
    const auto [in_folder, in_file] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    return in_folder == folder.end() && in_file != file.end();
}

}  // namespace

ModelFolder::ModelFolder(const fs::path& model, FileNotes& notes)
    : folder_(model.parent_path().empty() ? fs::path(".") : model.parent_path()), notes_(notes)
{
}

fs::path ModelFolder::find(std::string_view name, std::string_view place, std::string_view way_out, fs::path folder) const
{
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
    std::string shown(name.substr(0, 200));
    std::ranges::replace_if(shown, is_control, '?');
    const std::string begin = std::string(place) + ": \"" + shown + "\" ";
    const std::string below = part_below(name);
    constexpr std::size_t longest_name = 1024;
    constexpr std::ptrdiff_t most_parts = 64;
    if (below.empty() || name.size() > longest_name || std::ranges::distance(fs::path(below)) > most_parts ||
        std::ranges::any_of(name, is_control))
        throw Error(begin + "is not a file name");
    if (folder.empty())
        folder = folder_;
    fs::path file;
    try
    {
        const std::string found = find_listed_files({{folder, below, &file, false}}, folder_,
                                                    [&](const fs::path& pattern) { notes_.looked_for.push_back(pattern); });
        if (!found.empty())
            notes_.messages.push_back(std::string(place) + ": " + found);
    }
    catch (const Error& error)
    {
        throw Error(std::string(place) + ": " + error.what());
    }
    std::error_code error;
    if (!fs::is_regular_file(file, error))
        throw MissingInput(begin + "is not in " + folder.string() +
                           (below.find_first_of("/\\") == std::string::npos && below == name
                                ? ", nor with another case"
                                : ", nor with another case or by the last parts of its path") +
                           "; put it there" + std::string(way_out));
    if (!is_inside(fs::canonical(file), fs::canonical(folder_)))
        throw Error(begin + "is a link to a file outside the model's folder; put the file itself there");
    return file;
}

bool ModelFolder::has(std::string_view name) const
{
    const auto messages = notes_.messages;
    bool is_there = false;
    try
    {
        is_there = !find(name, "").empty();
    }
    catch (const Error&)
    {
    }
    notes_.messages = messages;
    return is_there;
}

bool is_system_file(const fs::path& file)
{
    const std::string name = file.filename().string();
    return name.starts_with("._") || name == ".DS_Store" || name == "Thumbs.db" || name == "desktop.ini" || name == "@eaDir";
}

}  // namespace fresco::recordings
