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

/// \file The study itself: which pictures are compared, under which questions, and its key, which the owner keeps to evaluate the
/// answers. The page and the results are made from it.

namespace study
{

/// The pictures of one method by name, usually that of the view. Pictures of equal names are compared.
struct MethodPictures
{
    std::string method;
    std::map<std::string, std::filesystem::path> files;
};

/// The pictures of one view by two or more methods.
struct Group
{
    std::string name;
    std::map<std::string, std::filesystem::path> files;  ///< By method.
};

/// The names that at least two methods have; at most `most` of them, evenly spread in the order of the names. Throws Error for
/// fewer than two methods, for two methods of one name (naming both), and if no name is common.
std::vector<Group> compared_groups(const std::vector<MethodPictures>& methods, std::size_t most);

struct Picture
{
    std::string method;
    std::string name;
    friend bool operator==(const Picture&, const Picture&) = default;
};

/// A rectangle drawn into both pictures of a view, where the answer to a question may be seen; in shares of the picture.
struct Hint
{
    std::string name;                     ///< The view's.
    std::optional<std::size_t> question;  ///< nullopt: for every question.
    double left = 0;
    double top = 0;
    double width = 0;
    double height = 0;
    friend bool operator==(const Hint&, const Hint&) = default;
};

/// Options of a study.
struct Design
{
    std::string ours;              ///< The method that all others are compared with; empty: all pairs of methods.
    bool mixes_questions = false;  ///< Questions in random order; else in sequence.
    std::vector<Hint> hints;
};

/// The questions and pictures, and the secret of the study's owner: the method of each picture.
struct Study
{
    std::string id;  ///< Hash of all other members and of the pictures' files.
    std::vector<std::string> questions;
    std::vector<Picture> pictures;  ///< Indexed by the page's numbers; shuffled.
    int pairs_count = 0;            ///< Maximum number of pairs per participant.
    Design design;
};

/// The pairs of pictures of two methods, as numbers.
struct Comparison
{
    std::string first;                                       ///< A method.
    std::string second;                                      ///< A later one in alphabetical order.
    std::vector<std::pair<std::size_t, std::size_t>> pairs;  ///< The first's picture and the second's.
};

/// The comparisons of the design that have pairs.
std::vector<Comparison> comparisons(const Study& study);

/// A study of these groups. `shown` describes how pictures are shown (size, format); the study's id depends on it. Throws Error
/// if `ours` is not one of the methods, or if a hint names a view or question that the study does not have.
Study make_study(const std::vector<Group>& groups, std::vector<std::string> questions, int pairs_count, Design design,
                 std::uint64_t seed, std::string_view shown);

/// A JSON list of `view`, `left`, `top`, `width`, `height` in shares of the picture, and `question`, counted from 0, or none.
/// Strict. Throws Error naming `source` and the entry.
std::vector<Hint> hints_from(std::string_view text, std::string_view source);

/// Texts separated by '|', without surrounding blanks. Throws Error if one is empty.
std::vector<std::string> split_questions(std::string_view text);

/// JSON text, from which key_from gives the study back. key_from throws Error naming `source` and the entry for anything else.
std::string key_text(const Study& study);
Study key_from(std::string_view text, std::string_view source);

}  // namespace study
