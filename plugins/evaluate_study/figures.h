#pragma once

#include "answers.h"

#include <fresco/evaluation/statistics.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace study
{

/// How often something was chosen.
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
    std::size_t participants = 0;  ///< Who answered it.
    std::int64_t answers = 0;
    std::array<Share, 3> shares;  ///< first, second, neither
    std::string preferred;        ///< The method that was chosen more often, where that can be said; else empty.
};

/// One verdict per question and comparison that has an answer, in the study's order. The 95 % interval of a share reaches over
/// two intervals: the bootstrap's, which draws whole participants (answers of one participant are alike), and Wilson's, which
/// knows that few or unanimous answers prove little. A method is preferred if at least two participants answered and its interval
/// lies above the other's.
std::vector<Verdict> verdicts(const Study& study, const std::vector<AnswerSheet>& sheets,
                              const fresco::evaluation::Bootstrap& bootstrap);

}  // namespace study
