#pragma once

#include "run/scheduler.h"
#include <fresco/value.h>

#include <cstddef>
#include <string>
#include <vector>

/// \file What a run of a matrix came to, by combination.

namespace fresco::host
{

struct CombinationOutcome
{
    const Combination* combination = nullptr;
    std::string state;               ///< "done", "failed", "not run", "interrupted".
    std::string stage;               ///< The first stage that failed; empty: none.
    double own_seconds = 0;          ///< Time of its own stages, now or when their results were made.
    std::size_t ran_count = 0;       ///< Stages that ran, shared ones too.
    std::size_t stored_count = 0;    ///< Stages whose result was there already.
    std::vector<std::size_t> files;  ///< Numbers in the summary's files, shared ones too.
};

/// One for each combination, in their order. The pipeline must outlive the result.
std::vector<CombinationOutcome> combination_outcomes(const Pipeline& pipeline, const RunSummary& summary, const Store& store);

/// Axis -> label.
Value::Map values_of(const Sweep& sweep, const Combination& combination);
/// First entries of a combination in JSON: name, values, state, failed_stage, error, own_seconds.
Value::Map combination_data(const Sweep& sweep, const RunSummary& summary, const CombinationOutcome& outcome);

/// The table that ends a run on a terminal of this width: a line per combination.
std::string sweep_table(const Sweep& sweep, const std::vector<CombinationOutcome>& outcomes, std::size_t width);

}  // namespace fresco::host
