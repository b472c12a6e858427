#pragma once

#include "base/file_stamp.h"
#include "pipeline/pipeline.h"
#include "store/statistics.h"
#include "store/store.h"

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// \file Which stages have their results, which must run, which may begin: the scheduler and `plan` ask it, and it is brought
/// up to date stage by stage.

namespace fresco::host
{

/// In the order of what to_string calls them.
enum class StageState
{
    not_selected,  ///< After the stage of `--until`.
    not_needed,    ///< No pending stage reads its result.
    stored,
    waiting,  ///< Must run (or cannot be known before what is above it ran).
    running,
    done,
    failed,
    blocked,  ///< Something above it failed.
    interrupted
};
std::string_view to_string(StageState state);

/// The stages, by place, and all that they need.
std::vector<bool> with_needed(const Pipeline& pipeline, std::vector<bool> stages);

/// One stage of a run.
struct StageNode
{
    const PipelineStage* stage = nullptr;
    std::vector<std::size_t> producers;
    std::vector<std::size_t> consumers;
    bool selected = false;
    bool may_run = true;  ///< False: its result must be in the store where something reads it.
    bool exports_files = false;
    StageState state = StageState::waiting;

    bool resolved = false;  ///< The key is known: all producers' results are.
    std::string key;
    Value key_document;
    std::map<std::string, std::string> upstream;  ///< Results that the key was made with.
    double done_share = 0;                        ///< Share of its work in the checkpoint of an interrupted run.
    std::string begins_again;                     ///< Why it cannot go on with that checkpoint; empty: it can.
    std::optional<StoredResult> result;
    bool present = false;
    std::string why_not;  ///< The outside file whose change is the reason for a missing result.

    Usage took;         ///< Usage in this run.
    int threads = 0;    ///< Threads in this run.
    std::string error;  ///< Error of a failed stage.
    int error_code = 0;
};

/// The stages of a pipeline that one process is to run, of those that others run.
struct RunPart
{
    std::set<std::string> stages;
    /// Message for a missing result of another stage.
    std::function<std::string(const PipelineStage&)> missing_text;
};

/// Knows which stages have their results in the store and which must run. It asks for results from the ends: a stage whose result
/// is gone runs only if something that must run reads it.
class RunState
{
  public:
    /// `until`: that stage and what it needs; empty: all. `part`: those stages and no others, whatever `until` says; null: no
    /// part. All must outlive it.
    RunState(const Pipeline& pipeline, const Store& store, FileHashes& hashes, const std::string& until,
             const RunPart* part = nullptr);

    std::vector<StageNode>& nodes() { return nodes_; }
    const std::vector<StageNode>& nodes() const { return nodes_; }

    /// Looks at the store anew and sets the states of all stages that are not running, failed or interrupted.
    void update();
    /// Does so after a change of one stage, only for the stages that read its result and those that only they need.
    void update(const StageNode& node);
    /// Places of the stages that may begin: they must run, and all producers' results are there.
    const std::set<std::size_t>& ready() const { return ready_; }
    /// Places of the stages whose result is there, and was not or was another at the call before; all after a full update.
    std::vector<std::size_t> take_arrived() { return std::exchange(arrived_, {}); }

  private:
    /// The part of a stage's state that other stages depend on.
    struct View
    {
        std::string result;
        bool present = false;
        bool broken = false;  ///< Stages behind it cannot run.
        bool reads = false;   ///< It needs its producers' results.
    };

    void settle();
    void ask_for(std::size_t place);
    void set_state(StageNode& node);
    void show(std::size_t place);
    void resolve(StageNode& node);

    const Store& store_;
    FileHashes& hashes_;
    const RunPart* part_;
    std::vector<StageNode> nodes_;
    std::vector<View> views_;
    std::set<std::size_t> to_look_at_;
    std::set<std::size_t> to_ask_for_;
    std::set<std::size_t> ready_;
    std::vector<std::size_t> arrived_;
};

}  // namespace fresco::host
