#include "base/glob.h"
#include "base/common.h"
#include "base/text.h"

#include <set>
#include <string>
#include <vector>

namespace fresco::host
{
namespace
{
constexpr int deepest_folder = 16;
constexpr std::uint64_t entry_limit = 200'000;

std::vector<std::string> split_pattern(std::string_view pattern)
{
    std::vector<std::string> parts;
    // Several "**" in a row match what one does, and would be tried in every combination.
    for (std::string& part : split(pattern, '/'))
        if (!part.empty() && !(part == "**" && !parts.empty() && parts.back() == "**"))
            parts.push_back(std::move(part));
    return parts;
}

class Walk
{
  public:
    explicit Walk(std::vector<std::string> parts) : parts_(std::move(parts)) {}

    /// `open` are the places in the pattern that may match the next name.
    void folder(const fs::path& path, const std::set<std::size_t>& open, int depth)
    {
        std::error_code failure;
        fs::directory_iterator entries(path, fs::directory_options::skip_permission_denied, failure);
        for (; !failure && entries != fs::directory_iterator(); entries.increment(failure))
        {
            if (left_ == 0)
            {
                result_.cut_short = true;
                return;
            }
            --left_;
            entry(*entries, open, depth);
        }
    }

    GlobMeasure result() const { return result_; }

  private:
    void entry(const fs::directory_entry& entry, const std::set<std::size_t>& open, int depth)
    {
        const std::string name = entry.path().filename().string();
        std::set<std::size_t> inner;
        bool whole = false;
        const auto pass = [&](std::size_t place)
        {
            const bool any = parts_[place] == "**";
            const bool last = place + 1 == parts_.size();
            if (!any && !name_matches(name, parts_[place]))
                return;
            whole = whole || last;
            if (any || !last)
                inner.insert(any ? place : place + 1);
        };
        for (const std::size_t place : open)
        {
            pass(place);
            // "**" may also stand for no folder at all.
            if (parts_[place] == "**" && place + 1 < parts_.size())
                pass(place + 1);
        }
        std::error_code failure;
        if (entry.is_directory(failure) && !entry.is_symlink(failure))
        {
            if (!inner.empty() && depth >= deepest_folder)
                result_.cut_short = true;
            else if (!inner.empty())
                folder(entry.path(), inner, depth + 1);
        }
        else if (whole && entry.is_regular_file(failure))
        {
            ++result_.files;
            const auto size = entry.file_size(failure);
            result_.bytes += failure ? 0 : size;
        }
    }

    std::vector<std::string> parts_;
    std::uint64_t left_ = entry_limit;
    GlobMeasure result_;
};
}  // namespace

bool name_matches(std::string_view name, std::string_view pattern)
{
    std::size_t n = 0;
    std::size_t p = 0;
    std::size_t star = std::string_view::npos;
    std::size_t after_star = 0;
    while (n < name.size())
    {
        if (p < pattern.size() && pattern[p] == '*')
        {
            star = p++;
            after_star = n;
        }
        else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n]))
        {
            ++p;
            ++n;
        }
        else if (star != std::string_view::npos)
        {
            // The last star takes one character more; an earlier one never has to.
            p = star + 1;
            n = ++after_star;
        }
        else
            return false;
    }
    while (p < pattern.size() && pattern[p] == '*')
        ++p;
    return p == pattern.size();
}

bool has_entry(const fs::path& root, std::string_view pattern)
{
    const std::size_t slash = pattern.find('/');
    const std::string_view name = pattern.substr(0, slash);
    const auto rest_in = [&](const fs::path& entry)
    { return slash == std::string_view::npos || has_entry(entry, pattern.substr(slash + 1)); };
    std::error_code failure;
    if (name.find_first_of("*?") == std::string_view::npos)
        return fs::exists(root / name, failure) && rest_in(root / name);
    fs::directory_iterator entry(root, failure);
    for (; !failure && entry != fs::directory_iterator(); entry.increment(failure))
        if (name_matches(entry->path().filename().string(), name) && rest_in(entry->path()))
            return true;
    return false;
}

GlobMeasure measure_files(const fs::path& root, std::string_view pattern)
{
    std::error_code failure;
    if (fs::is_regular_file(root, failure))
    {
        const auto size = fs::file_size(root, failure);
        return {1, failure ? 0 : size, false};
    }
    std::vector<std::string> parts = split_pattern(pattern);
    if (parts.empty())
        parts.emplace_back("**");
    Walk walk(std::move(parts));
    walk.folder(root, {0}, 1);
    return walk.result();
}

}  // namespace fresco::host
