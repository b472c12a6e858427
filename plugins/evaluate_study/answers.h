#pragma once

#include "study.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace study
{

enum class Choice
{
    left,
    right,
    neither
};

struct Answer
{
    std::size_t question = 0;
    std::size_t left = 0;  ///< Number of the picture that was on the left.
    std::size_t right = 0;
    Choice choice = Choice::neither;
    double seconds = 0;  ///< From showing the pair to the answer.
};

/// The file that a participant's page made.
struct AnswerSheet
{
    std::string participant;
    bool complete = false;
    std::vector<Answer> answers;
};

/// Strict. Throws Error naming `source`, the entry and what to do for text in another format, answers of another study,
/// pictures that were never compared, a pair answered twice, and numbers out of range.
AnswerSheet sheet_from(std::string_view text, std::string_view source, const Study& study);

/// The sheets of these files, in the order of the participants' codes. Throws Error as sheet_from, and naming both files if two
/// are of one participant.
std::vector<AnswerSheet> read_sheets(const std::vector<std::filesystem::path>& files, const Study& study);

}  // namespace study
