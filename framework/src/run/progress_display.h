#pragma once

#include "run/run_state.h"
#include <fresco/value.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file What shows a run: display/ on the terminal, or nothing.

namespace fresco::host
{

/// Outcome of one stage in a run.
struct StageOutcome
{
    std::string stage;
    std::string type;
    StageState state = StageState::not_selected;
    std::string key;  ///< Key of its result; empty: not known.
    std::string object;
    double seconds = 0;
    double memory_mb = 0;
    double disk_mb = 0;
    int threads = 0;
    std::string error;

    /// Whether it ran, and the figures are those of this run.
    bool is_of_this_run() const
    {
        return state == StageState::done || state == StageState::failed || state == StageState::interrupted;
    }
};

/// How a stage of a run stands.
struct StageStanding
{
    std::string stage;
    StageState state = StageState::waiting;
    double expected_s = 0;                 ///< Time by earlier runs; 0: unknown.
    std::filesystem::path preview_folder;  ///< Folder of its progress pictures, if it makes any.
};

/// Shows a run to a person or a machine while it goes on. What it does not override it does not show.
class ProgressDisplay
{
  public:
    virtual ~ProgressDisplay() = default;
    /// All stages in their order before the first begins; later those whose state changed.
    virtual void stages(const std::vector<StageStanding>& /*stages*/, int /*cores*/) {}
    virtual void stage_begins(const std::string& /*stage*/, int /*threads*/) {}
    /// Another run makes the result; this one waits for it. `holder`: "process 4711 on kitchen, since …", empty
    /// if unknown. Called again where another gets in between.
    virtual void stage_waits(const std::string& /*stage*/, const std::string& /*holder*/) {}
    virtual void stage_progress(const std::string& /*stage*/, double /*done*/, double /*total*/, const std::string& /*unit*/,
                                const Value& /*metrics*/)
    {
    }
    virtual void stage_says(const std::string& /*stage*/, const std::string& /*text*/, bool /*warning*/) {}
    /// A line that a library printed.
    virtual void stage_prints(const std::string& /*stage*/, const std::string& /*line*/) {}
    virtual void stage_ends(const StageOutcome& outcome) = 0;
    virtual void exported(const std::string& /*stage*/, const std::filesystem::path& /*file*/, bool /*written*/) {}
    virtual void note(const std::string& /*text*/) {}
    /// Called several times a second.
    virtual void tick() {}
};

}  // namespace fresco::host
