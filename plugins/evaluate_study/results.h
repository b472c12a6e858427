#pragma once

#include "figures.h"

#include <fresco/value.h>

#include <string>
#include <vector>

namespace study
{

/// "Which is better? ours 61.3 % [55.0, 67.1], …": a verdict for a person.
std::string verdict_line(const Study& study, const Verdict& verdict);

/// Everything that the sheets tell, as a map for a program: question by question, in the order of the verdicts.
fresco::Value results_value(const Study& study, const std::vector<AnswerSheet>& sheets, const std::vector<Verdict>& verdicts);

}  // namespace study
