#pragma once

#include "base/machine.h"
#include "base/process.h"
#include "run/progress_display.h"
#include "run/run_state.h"
#include "run/scheduler.h"
#include "store/stage_log.h"
#include "worker/worker.h"

#include <chrono>
#include <deque>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

/// \file The host's side of a stage that runs in its own process: starts it, listens, limits it, and says how it ended. The
/// scheduler holds one for each.

namespace fresco::host
{

/// A WorkerRequest for a stage whose producers' results are all there, as JSON.
Value make_worker_request(const StageNode& node, const RunState& state, const Store& store, const std::filesystem::path& out,
                          int threads, FileHashes& hashes);

/// The folder of a stage's previews while it runs.
std::filesystem::path preview_folder(const std::filesystem::path& out, const PipelineStage& stage);

/// The answer of a worker about its stage.
struct StageAnswer
{
    std::optional<StoredResult> result;
    bool was_stored = false;  ///< The result was there already.
    Usage took;               ///< Making the result.
    std::optional<Damage> damage;
    std::string failure;
    bool was_canceled = false;  ///< It stopped on request.
};

/// A stage at work in its process.
class RunningStage
{
  public:
    /// Starts the process. Throws Error if that fails.
    RunningStage(StageNode& node, const Value& request, const Store& store, const StageLimits& limits, ProgressDisplay& display);
    ~RunningStage();
    RunningStage(const RunningStage&) = delete;
    RunningStage& operator=(const RunningStage&) = delete;

    StageNode& node() const { return *node_; }
    int threads() const { return threads_; }
    pid_t process() const { return child_.pid; }
    int event_descriptor() const { return child_.channel.get(); }
    int output_descriptor() const { return child_.output.get(); }
    /// Passes on what the process said and printed.
    void take_events();
    /// True once the process has ended and everything it said was taken.
    bool ended();

    /// SIGTERM: the stage stops at its next check. SIGKILL: now, with all that it started.
    void stop(int signal) const;
    /// Ends the stage if it uses more than its limits. To be called a few times a second.
    void hold_to_limits();

    const ProcessEnd& end() const { return end_; }
    const StageAnswer& answer() const { return answer_; }
    bool exceeded_limit() const { return !limit_text_.empty(); }
    double elapsed() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    /// Why the process ended without a result, in words, and the command that shows all it printed, where that is more.
    std::string failure_text(const std::filesystem::path& pipeline) const;
    /// The host's exit code for it.
    int failure_code() const;

  private:
    std::string end_text() const;
    bool take_next_event();
    void take_event(const std::string& line);
    void take_print(const std::string& line);
    void take_result(const Value& event);
    void end_for(std::string limit, int signal);

    StageNode* node_;
    const Store* store_;
    StageLimits limits_;
    ProgressDisplay* display_;
    int threads_;
    std::set<std::string> inputs_;  ///< Results that it reads.
    std::filesystem::path request_folder_;
    std::int64_t oom_kills_ = oom_kills();
    Child child_;
    LineBuffer events_{std::size_t{1} << 24U};
    LineBuffer output_;
    std::deque<std::string> tail_;  ///< The last lines that it printed.
    std::size_t printed_lines_ = 0;
    bool resumes_;
    StageLog log_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    ProcessEnd end_;
    StageAnswer answer_;
    std::string limit_text_;  ///< Names the limit that it was ended for; empty: none.
    std::chrono::steady_clock::time_point kill_time_;
    std::chrono::steady_clock::time_point memory_time_;
    bool runs_ = false;
};

/// "room.yaml:7:3: error: stage mesh (mesh.decimate): TEXT" and the inputs it worked on.
std::string stage_error_text(const PipelineStage& stage, const std::string& text);

/// Names possible causes for a result that is damaged again after it was recomputed.
std::string repeated_damage_text(const Damage& damage, const RunState& state);

}  // namespace fresco::host
