#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// \file Names in pipelines, and pieces of messages to users.

namespace fresco
{

/// The candidate nearest to `word` if it is near enough to be meant (about a third of the letters), else an empty text. Upper and
/// lower case, '-' and '_' count as equal; of equally near ones the first.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

/// " (did you mean 'x'?)" or, where nothing is near, " (there are: a, b, c)"; empty when there are no candidates. At most
/// `most_listed` candidates are listed.
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates, std::size_t most_listed = 12);

/// "a, b and c".
std::string join(const std::vector<std::string>& words, std::string_view before_last = " and ");

/// Letters, digits, '_' and '-', not beginning with a digit or '-': what stages, vars and ports are called.
bool is_name(std::string_view text);

/// With the letters A to Z in lower case, whatever the locale.
std::string lower_case(std::string text);
/// Extension of a file's name, in lower case, with the dot: ".png".
std::string lower_extension(const std::filesystem::path& file);

/// A number as a user would write it: 4, 0.5, 1e-06.
std::string number_text(double number);

}  // namespace fresco
