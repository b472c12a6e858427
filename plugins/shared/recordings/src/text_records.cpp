#include <fresco/recordings/text_records.h>

#include <fresco/error.h>
#include <fresco/numerics/rotations.h>
#include <fresco/value.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace fresco::recordings
{
namespace
{

constexpr std::size_t shown_word = 40;
constexpr std::size_t most_digits = 18;  // Those that fit into a long.
constexpr std::string_view blanks = " \t\r";

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

std::string shown(std::string_view word)
{
    return "\"" + std::string(word.substr(0, shown_word)) + "\"";
}

/// The length of the run of digits at the front.
std::size_t digits_at(std::string_view text)
{
    return static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_digit) - text.begin());
}

}  // namespace

LineReader::LineReader(std::string_view text, std::string_view source) : rest_(text), source_(source)
{
    if (text.empty() || text.back() != '\n')
        throw Error(
            source_ +
            ": the last line has no newline: the file may be truncated; copy it again (if it is complete, add a final newline)");
}

std::optional<std::string_view> LineReader::next()
{
    if (rest_.empty())
        return std::nullopt;
    const auto end = rest_.find('\n');
    auto line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    ++line_;
    if (line.ends_with('\r'))
        line.remove_suffix(1);
    return line;
}

std::optional<std::string_view> LineReader::next_record()
{
    while (const auto line = next())
        if (const auto first = line->find_first_not_of(blanks); first != std::string_view::npos && (*line)[first] != '#')
            return line;
    return std::nullopt;
}

std::string LineReader::place() const
{
    return fmt::format("{}:{}", source_, line_);
}

std::vector<std::string_view> words_of(std::string_view line, std::string_view separators)
{
    std::vector<std::string_view> words;
    while (true)
    {
        const auto begin = line.find_first_not_of(separators);
        if (begin == std::string_view::npos)
            return words;
        const auto end = std::min(line.find_first_of(separators, begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        line.remove_prefix(end);
    }
}

double number_of(std::string_view word, const std::string& place)
{
    double number = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (code != std::errc{} || end != word.data() + word.size() || !std::isfinite(number))
        throw Error(place + ": " + shown(word) + ": expected a finite number");
    return number;
}

std::int64_t integer_of(std::string_view word, std::int64_t least, std::int64_t most, const std::string& place)
{
    std::int64_t number = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (code != std::errc{} || end != word.data() + word.size() || number < least || number > most)
        throw Error(fmt::format("{}: {}: expected a whole number from {} to {}", place, shown(word), least, most));
    return number;
}

RigidTransform quaternion_transform(double w, double x, double y, double z, Vec3d translation, const std::string& place)
{
    const double norm = std::sqrt(w * w + x * x + y * y + z * z);
    if (!(std::abs(norm - 1) <= 0.01))
        throw Error(place + ": expected a rotation, a quaternion of length 1; its length is " +
                    (std::isfinite(norm) ? to_json(std::round(norm * 1e4) / 1e4) : "none") + "; check the order of the columns");
    if (!std::isfinite(translation.x) || !std::isfinite(translation.y) || !std::isfinite(translation.z))
        throw Error(place + ": the translation is not finite");
    return {numerics::rotation_of(w / norm, x / norm, y / norm, z / norm), translation};
}

bool natural_less(std::string_view a, std::string_view b)
{
    const std::string_view all_a = a, all_b = b;
    while (!a.empty() && !b.empty())
    {
        if (is_digit(a.front()) && is_digit(b.front()))
        {
            const auto significant = [](std::string_view run)
            { return run.substr(std::min(run.find_first_not_of('0'), run.size())); };
            const auto length_a = digits_at(a), length_b = digits_at(b);
            const auto number_a = significant(a.substr(0, length_a)), number_b = significant(b.substr(0, length_b));
            if (number_a.size() != number_b.size())
                return number_a.size() < number_b.size();
            if (number_a != number_b)
                return number_a < number_b;
            a.remove_prefix(length_a);
            b.remove_prefix(length_b);
            continue;
        }
        if (a.front() != b.front())
            return a.front() < b.front();
        a.remove_prefix(1);
        b.remove_prefix(1);
    }
    if (a.empty() != b.empty())
        return a.empty();
    // "01" and "1" are the same number: the texts decide.
    return all_a < all_b;
}

std::optional<long> number_after(std::string_view text, std::string_view prefix)
{
    if (!text.starts_with(prefix))
        return std::nullopt;
    const auto digits = text.substr(prefix.size());
    if (digits.empty() || digits_at(digits) != digits.size())
        return std::nullopt;
    return last_number(digits);
}

std::optional<long> last_number(std::string_view text)
{
    const auto last = std::find_if(text.rbegin(), text.rend(), is_digit);
    const auto end = static_cast<std::size_t>(text.rend() - last);
    const auto first = std::find_if_not(last, text.rend(), is_digit);
    const auto begin = static_cast<std::size_t>(text.rend() - first);
    if (begin == end || end - begin > most_digits)
        return std::nullopt;
    long number = 0;
    std::from_chars(text.data() + begin, text.data() + end, number);
    return number;
}

}  // namespace fresco::recordings
