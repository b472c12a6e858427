#pragma once

#include "base/machine.h"
#include "base/process.h"
#include "run/progress_display.h"
#include "run/run_state.h"
#include "run/stage_limits.h"
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

/// The request for a stage whose producers' results are all there.
WorkerRequest make_worker_request(const StageNode& node, const RunState& state, const Store& store,
                                  const std::filesystem::path& out, int threads, FileHashes& hashes);

/// A stage at work in its process.
class RunningStage
{
  public:
    /// Starts the process. Throws Error if that fails.
    RunningStage(StageNode& node, const WorkerRequest& request, const Store& store, const StageLimits& limits,
                 ProgressDisplay& display);
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
    const std::optional<StoredResult>& result() const { return result_; }
    bool was_stored() const { return was_stored_; }
    const std::optional<Damage>& damage() const { return damage_; }
    /// Why a result could not be copied from another store; empty: it could.
    const std::string& not_fetched() const { return not_fetched_; }
    const std::string& failure() const { return failure_; }
    /// Which limit it was ended for, in words; or empty.
    const std::string& limit_text() const { return limit_text_; }
    const StageLimits& limits() const { return limits_; }
    /// The system killed some process since the start, because memory ran out.
    bool memory_ran_out() const { return oom_kills() > oom_kills_; }
    /// It said that it stopped on request.
    bool was_canceled() const { return was_canceled_; }
    /// The last lines that it printed, tail_lines at most.
    std::string printed_tail() const;
    static constexpr std::size_t tail_lines = 12;
    std::size_t printed_lines() const { return printed_lines_; }
    double elapsed() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    double seconds() const { return seconds_; }
    double memory_mb() const { return memory_mb_; }
    double disk_mb() const { return disk_mb_; }

  private:
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
    std::deque<std::string> tail_;
    std::size_t printed_lines_ = 0;
    bool resumes_;
    StageLog log_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    ProcessEnd end_;
    std::optional<StoredResult> result_;
    std::optional<Damage> damage_;
    std::string not_fetched_;
    std::string failure_;
    std::string limit_text_;
    std::chrono::steady_clock::time_point kill_time_;
    std::chrono::steady_clock::time_point memory_time_;
    bool runs_ = false;
    bool was_canceled_ = false;
    bool was_stored_ = false;
    double seconds_ = 0;
    double memory_mb_ = 0;
    double disk_mb_ = 0;
};

/// "room.yaml:7:3: error: stage mesh (mesh.decimate): TEXT" and the inputs it worked on.
std::string stage_error_text(const PipelineStage& stage, const std::string& text);

/// Of a result that is damaged again after it was recomputed: what may do that.
std::string repeated_damage_text(const Damage& damage, const RunState& state);

/// Why a stage's process ended without a result, in words, and the command that shows all it printed, where that is more.
std::string failure_text(const RunningStage& running, const std::filesystem::path& pipeline, const std::filesystem::path& store);
/// The host's exit code for it.
int failure_code(const RunningStage& running);

}  // namespace fresco::host
