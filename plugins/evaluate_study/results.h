#pragma once

#include "study.h"

#include <fresco/evaluation/statistics.h>
#include <fresco/value.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// \file Evaluates the answers of participants: reads their files, counts choices, and says which method was preferred. The stage
/// calls it once answers are given to it.

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

/// The file that the page saved for a participant.
struct AnswerSheet
{
    std::string participant;
    bool complete = false;
    std::vector<Answer> answers;
};

/// Strict. Throws Error naming `source`, the entry and what to do for text in another format, answers of another study,
/// pictures that were not compared, a pair with two answers, and numbers out of range.
AnswerSheet sheet_from(std::string_view text, std::string_view source, const Study& study);

/// The sheets of these files, in the order of the participants' codes. Throws Error as sheet_from, and naming both files if two
/// are from one participant.
std::vector<AnswerSheet> read_sheets(const std::vector<std::filesystem::path>& files, const Study& study);

/// The share of a choice.
struct Share
{
    std::int64_t count = 0;
    double value = 0;  ///< Of the answers; NaN without answers.
    fresco::evaluation::Interval interval;
};

/// The answers to one question about pairs of two methods.
struct Verdict
{
    std::size_t question = 0;
    std::string first;
    std::string second;
    std::size_t participants = 0;  ///< Number of participants who answered it.
    std::int64_t answers = 0;
    std::array<Share, 3> shares;  ///< first, second, neither
    std::string preferred;        ///< The method that was clearly chosen more often; else empty.
};

/// One verdict per question and comparison that has an answer, in the study's order. The 95 % interval of a share
/// contains two intervals: the bootstrap's, which draws whole participants because their answers are correlated, and Wilson's,
/// which stays wide for few or unanimous answers. A method is preferred if at least two participants answered and its interval
/// lies above the other's.
std::vector<Verdict> verdicts(const Study& study, const std::vector<AnswerSheet>& sheets,
                              const fresco::evaluation::Bootstrap& bootstrap);

/// "Which is better? ours 61.3 % [55.0, 67.1], …": a verdict for people.
std::string verdict_line(const Study& study, const Verdict& verdict);

/// All results as a map, for programs: question by question, in the order of the verdicts.
fresco::Value results_value(const Study& study, const std::vector<AnswerSheet>& sheets, const std::vector<Verdict>& verdicts);

}  // namespace study
