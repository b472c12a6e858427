#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace fresco
{
namespace
{
/// Longer words are compared by their beginnings: the table stays small whatever a file holds.
constexpr std::size_t longest_compared = 128;

char folded(char c)
{
    if (c >= 'A' && c <= 'Z')
        return static_cast<char>(c - 'A' + 'a');
    return c == '-' ? '_' : c;
}

std::string folded(std::string_view word)
{
    std::string result(word.substr(0, longest_compared));
    std::transform(result.begin(), result.end(), result.begin(), [](char c) { return folded(c); });
    return result;
}
}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> before_last(b.size() + 1);
    std::vector<std::size_t> last(b.size() + 1);
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j)
        row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i)
    {
        before_last.swap(last);
        last.swap(row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j)
        {
            const std::size_t substitution = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, substitution});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
    }
    return row[b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates)
{
    const std::string wanted = folded(word);
    std::size_t best = std::max<std::size_t>(1, (wanted.size() + 2) / 3) + 1;
    std::string result;
    for (const std::string& candidate : candidates)
    {
        const std::size_t distance = edit_distance(wanted, folded(candidate));
        // A word with all of its letters replaced is another word.
        if (distance < best && distance < std::max(wanted.size(), candidate.size()))
        {
            best = distance;
            result = candidate;
        }
    }
    if (!result.empty() || wanted.size() < 3)
        return result;
    // What was shortened ("decimate" for "mesh.decimate", "max" for "max_faces") is far by letters and still meant.
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
    std::string text = " (there are: ";
    for (std::size_t i = 0; i < candidates.size() && i < most_listed; ++i)
        text += (i == 0 ? "" : ", ") + candidates[i];
    return text + (candidates.size() > most_listed ? ", …)" : ")");
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

std::string number_text(double number)
{
    std::array<char, 64> buffer{};
    const bool whole = std::abs(number) < 1e15 && number == std::floor(number);
    const auto end = whole ? std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<long long>(number)).ptr
                           : std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
    return std::string(buffer.data(), end);
}

}  // namespace fresco
