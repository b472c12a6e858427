#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
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

/// The edit distance, or `limit` if it is not below. A prefix of `i` letters and one of `j` are at least |i - j| apart: only
/// those nearer than `limit` are compared, and no more once a whole row has reached it.
std::size_t edit_distance_below(std::string_view a, std::string_view b, std::size_t limit)
{
    if (std::max(a.size(), b.size()) - std::min(a.size(), b.size()) >= limit)
        return limit;
    std::vector<std::size_t> before_last(b.size() + 1, limit);
    std::vector<std::size_t> last(b.size() + 1, limit);
    std::vector<std::size_t> row(b.size() + 1, limit);
    for (std::size_t j = 0; j <= b.size() && j < limit; ++j)
        row[j] = j;
    std::size_t least_before = 0;
    for (std::size_t i = 1; i <= a.size(); ++i)
    {
        before_last.swap(last);
        last.swap(row);
        const std::size_t first = i < limit ? 1 : i - limit + 1;
        const std::size_t end = std::min(b.size(), i + limit - 1);
        row[first - 1] = first == 1 ? std::min(i, limit) : limit;
        std::size_t least = row[first - 1];
        for (std::size_t j = first; j <= end; ++j)
        {
            const std::size_t substitution = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, substitution, limit});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
            least = std::min(least, row[j]);
        }
        if (end < b.size())
            row[end + 1] = limit;
        // A swap of neighbors leads from one row to the next but one.
        if (std::min(least, least_before) >= limit)
            return limit;
        least_before = least;
    }
    return row[b.size()];
}
}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b)
{
    return edit_distance_below(a, b, std::max(a.size(), b.size()) + 1);
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates)
{
    const std::string wanted = folded(word);
    std::size_t best = std::max<std::size_t>(1, (wanted.size() + 2) / 3) + 1;
    std::string result;
    for (const std::string& candidate : candidates)
    {
        const std::size_t distance = edit_distance_below(wanted, folded(candidate), best);
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
    std::array<char, 64> buffer{};
    const bool whole = std::abs(number) < 1e15 && number == std::floor(number);
    const auto end = whole ? std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<long long>(number)).ptr
                           : std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
    return std::string(buffer.data(), end);
}

Error::~Error() = default;
MissingInput::~MissingInput() = default;

Canceled::Canceled() : std::runtime_error("The run was interrupted.") {}
Canceled::~Canceled() = default;

}  // namespace fresco
