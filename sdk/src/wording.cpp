#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <span>

namespace fresco
{
namespace
{
/// Longer words are compared by their beginnings: the table stays small whatever a file holds.
constexpr std::size_t longest_compared = 64;

std::string folded(std::string_view word)
{
    std::string result = lower_case(std::string(word.substr(0, longest_compared)));
    std::ranges::replace(result, '-', '_');
    return result;
}

/// Damerau-Levenshtein distance (optimal string alignment) of folded words: insertions, deletions, substitutions and swaps of
/// neighbors, by byte.
std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::array<std::array<std::size_t, longest_compared + 1>, longest_compared + 1> distance;
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j)
        {
            std::size_t& best = distance[i][j];
            best = i + j;
            if (i == 0 || j == 0)
                continue;
            const std::size_t substitution = distance[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            best = std::min({distance[i - 1][j] + 1, distance[i][j - 1] + 1, substitution});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                best = std::min(best, distance[i - 2][j - 2] + 1);
        }
    return distance[a.size()][b.size()];
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& candidates)
{
    const std::string wanted = folded(word);
    std::size_t best = std::max<std::size_t>(1, (wanted.size() + 2) / 3) + 1;
    std::string result;
    for (const std::string& candidate : candidates)
    {
        const std::string found = folded(candidate);
        if (std::max(found.size(), wanted.size()) - std::min(found.size(), wanted.size()) >= best)
            continue;
        const std::size_t distance = edit_distance(wanted, found);
        // A word with all of its letters replaced is another word.
        if (distance < best && distance < std::max(wanted.size(), candidate.size()))
        {
            best = distance;
            result = candidate;
        }
    }
    if (!result.empty() || wanted.size() < 3)
        return result;
    // Shortened names ("decimate" for "mesh.decimate", "max" for "max_faces") are far by letters and still meant.
    for (const std::string& candidate : candidates)
        if (folded(candidate).find(wanted) != std::string::npos && (result.empty() || candidate.size() < result.size()))
            result = candidate;
    return result;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates, std::size_t most_listed)
{
    if (candidates.empty())
        return {};
    if (const std::string best = nearest(word, candidates); !best.empty())
        return " (did you mean '" + best + "'?)";
    const std::span listed(candidates.data(), std::min(candidates.size(), most_listed));
    return fmt::format(" (there are: {}{})", fmt::join(listed, ", "), listed.size() < candidates.size() ? ", …" : "");
}

std::string join(const std::vector<std::string>& words, std::string_view before_last)
{
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i)
    {
        if (i > 0)
            text += i + 1 == words.size() ? before_last : std::string_view(", ");
        text += words[i];
    }
    return text;
}

bool is_name(std::string_view text)
{
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    const auto is_inner = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '-'; };
    return !text.empty() && is_letter(text.front()) && std::ranges::all_of(text, is_inner);
}

std::string lower_case(std::string text)
{
    std::ranges::transform(text, text.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

std::string lower_extension(const std::filesystem::path& file)
{
    return lower_case(file.extension().string());
}

std::string number_text(double number)
{
    return fmt::format("{}", number);
}

Error::~Error() = default;
MissingInput::~MissingInput() = default;

Canceled::Canceled() : std::runtime_error("The run was interrupted.") {}
Canceled::~Canceled() = default;

}  // namespace fresco
