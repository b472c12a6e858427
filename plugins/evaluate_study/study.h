#pragma once

#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace study
{

/// The pictures of one method, by name: what they show. Pictures of equal names are compared.
struct MethodPictures
{
    std::string method;
    std::map<std::string, std::filesystem::path> files;
};

/// What two or more methods made of one view.
struct Group
{
    std::string name;
    std::map<std::string, std::filesystem::path> files;  ///< By method.
};

/// The names that two methods at least have, `most` of them at most, evenly spread in the order of the names. Throws Error naming
/// both if there are fewer than two methods, two of one name, or no name in common.
std::vector<Group> compared_groups(const std::vector<MethodPictures>& methods, std::size_t most);

struct Picture
{
    std::string method;
    std::string name;
    friend bool operator==(const Picture&, const Picture&) = default;
};

/// A rectangle that is drawn into both pictures of a view, where a question's answer may be seen; in shares of the picture.
struct Hint
{
    std::string name;                     ///< The view's.
    std::optional<std::size_t> question;  ///< None: with every question.
    double left = 0;
    double top = 0;
    double width = 0;
    double height = 0;
    friend bool operator==(const Hint&, const Hint&) = default;
};

/// How a study is laid out.
struct Design
{
    std::string ours;              ///< The method that each other one is compared with; empty: every two methods are compared.
    bool mixes_questions = false;  ///< Questions in random order; else one after the other.
    std::vector<Hint> hints;
};

/// What participants are asked, and what only the study's owner knows: who made which picture.
struct Study
{
    std::string id;  ///< Hash of all the rest and of the pictures' files.
    std::vector<std::string> questions;
    std::vector<Picture> pictures;  ///< By the number that the page calls them by; shuffled.
    int pairs_count = 0;            ///< How many pairs each participant is shown, at most.
    Design design;
};

/// The pairs of pictures of two methods, as numbers.
struct Comparison
{
    std::string first;                                       ///< A method, …
    std::string second;                                      ///< … and a later one in the alphabet.
    std::vector<std::pair<std::size_t, std::size_t>> pairs;  ///< The first's picture and the second's.
};

/// By methods, as the design wants them; only those with pairs.
std::vector<Comparison> comparisons(const Study& study);

/// A study of these groups. `shown` says how pictures are shown (size, format) and counts toward the study's id. Throws Error if
/// `ours` is not one of the methods, or if a hint names a view or question that the study does not have.
Study make_study(const std::vector<Group>& groups, std::vector<std::string> questions, int pairs_count, Design design,
                 std::uint64_t seed, std::string_view shown);

/// A JSON list of `view`, `left`, `top`, `width`, `height` in shares of the picture, and `question`, counted from 0, or none.
/// Strict. Throws Error naming `source` and the entry.
std::vector<Hint> hints_from(std::string_view text, std::string_view source);

/// Texts separated by '|', without blanks around. Throws Error if one is empty.
std::vector<std::string> split_questions(std::string_view text);

/// JSON text, from which key_from gives the study back. key_from throws Error naming `source` and the entry for anything else.
std::string key_text(const Study& study);
Study key_from(std::string_view text, std::string_view source);

}  // namespace study
