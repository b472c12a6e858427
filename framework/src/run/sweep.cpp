#include "run/sweep.h"
#include "base/common.h"
#include "base/text.h"
#include <fresco/error.h>

#include <fmt/format.h>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{

/// Time that a stored result took when it was made.
double seconds_of(const StageOutcome& stage, const Store& store)
{
    if (stage.is_of_this_run())
        return stage.seconds;
    return attempt([&] { return store.manifest(stage.object).at("seconds").as_double(); }).value_or(0);
}

}  // namespace

std::vector<CombinationOutcome> combination_outcomes(const Pipeline& pipeline, const RunSummary& summary, const Store& store)
{
    std::map<std::string, std::vector<std::size_t>> files;
    for (std::size_t i = 0; i < summary.files.size(); ++i)
        files[summary.files[i].stage].push_back(i);
    std::vector<CombinationOutcome> result;
    for (const Combination& combination : pipeline.sweep.combinations)
    {
        CombinationOutcome outcome{&combination, "done", "", 0, 0, 0, {}};
        std::set<StageState> states;
        for (const std::size_t number : combination.stages)
        {
            const StageOutcome* stage = summary.outcome_of(pipeline.stages[number].name);
            if (stage == nullptr)
                continue;
            if (pipeline.stages[number].place == combination.name)
                outcome.own_seconds += seconds_of(*stage, store);
            outcome.ran_count += stage->state == StageState::done ? 1 : 0;
            outcome.stored_count += stage->state == StageState::stored ? 1 : 0;
            if (stage->state == StageState::failed && outcome.stage.empty())
                outcome.stage = stage->stage;
            states.insert(stage->state);
            const auto& made = files[stage->stage];
            outcome.files.insert(outcome.files.end(), made.begin(), made.end());
        }
        if (!outcome.stage.empty())
            outcome.state = "failed";
        else if (states.contains(StageState::interrupted))
            outcome.state = "interrupted";
        else if (states.contains(StageState::blocked))
            outcome.state = "not run";
        result.push_back(std::move(outcome));
    }
    return result;
}

Value::Map values_of(const Sweep& sweep, const Combination& combination)
{
    Value::Map values;
    for (std::size_t axis = 0; axis < combination.values.size(); ++axis)
        values.emplace_back(sweep.axes[axis], combination.values[axis]);
    return values;
}

Value::Map combination_data(const Sweep& sweep, const RunSummary& summary, const CombinationOutcome& outcome)
{
    const StageOutcome* failed = outcome.stage.empty() ? nullptr : summary.outcome_of(outcome.stage);
    return {{"name", outcome.combination->name},
            {"values", values_of(sweep, *outcome.combination)},
            {"state", outcome.state},
            {"failed_stage", outcome.stage},
            {"error", failed != nullptr ? failed->error : ""},
            {"own_seconds", outcome.own_seconds}};
}

std::string sweep_table(const Sweep& sweep, const std::vector<CombinationOutcome>& outcomes, std::size_t width)
{
    using Kind = TextTable::Kind;
    std::vector<TextTable::Column> columns;
    for (const std::string& axis : sweep.axes)
        columns.push_back({axis, Kind::figure});
    columns.insert(columns.end(), {{"", Kind::figure},
                                   {"own time", Kind::number},
                                   {"ran", Kind::number},
                                   {"stored", Kind::number},
                                   {"files", Kind::number},
                                   {"", Kind::text}});
    TextTable table(std::move(columns));
    std::map<std::string, std::size_t> states;
    for (const CombinationOutcome& outcome : outcomes)
    {
        ++states[outcome.state];
        std::vector<std::string> row = outcome.combination->values;
        row.insert(row.end(), {outcome.state, outcome.own_seconds > 0 ? duration_text(outcome.own_seconds) : "",
                               std::to_string(outcome.ran_count), std::to_string(outcome.stored_count),
                               std::to_string(outcome.files.size()), outcome.stage.empty() ? "" : "at " + outcome.stage});
        table.add(std::move(row));
    }
    std::string counts;
    for (const char* state : {"done", "failed", "interrupted", "not run"})
        if (states.contains(state))
            counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", states[state], state);
    return table.text(width) +
           folded(fmt::format("{} combination{}: {}\n", outcomes.size(), outcomes.size() == 1 ? "" : "s", counts), width);
}

}  // namespace fresco::host
