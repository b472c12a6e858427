#include <fresco/error.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>

#include <algorithm>
#include <array>
#include <cctype>
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
                found->second.emplace(lower(entry.path().filename().string()), entry.path());
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
                const auto [first, last] = listing(place).equal_range(lower(part.string()));
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

bool is_system_file(const fs::path& file)
{
    const std::string name = file.filename().string();
    return name.starts_with("._") || name == ".DS_Store" || name == "Thumbs.db" || name == "desktop.ini" || name == "@eaDir";
}

}  // namespace fresco::recordings
