#pragma once

#include "base/file_stamp.h"
#include "pipeline/pipeline.h"
#include "store/statistics.h"
#include "store/store.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fresco::host
{

enum class StageState
{
    not_selected,  ///< Behind `--until`.
    not_needed,    ///< Nothing that must run reads its result.
    stored,
    waiting,  ///< Must run (or cannot be known before what is above it ran).
    running,
    done,
    failed,
    blocked,  ///< Something above it failed.
    interrupted
};
std::string_view to_string(StageState state);

/// One stage of a run.
struct StageNode
{
    const PipelineStage* stage = nullptr;
    std::vector<std::size_t> producers;
    std::vector<std::size_t> consumers;
    bool selected = true;
    bool exports_files = false;
    StageState state = StageState::waiting;

    bool resolved = false;  ///< The key is known: all producers' results are.
    std::string key;
    Value key_document;
    std::map<std::string, std::string> upstream;  ///< Results that the key was made with.
    double done_share = 0;                        ///< Of its work, in the checkpoint of an interrupted run.
    std::optional<StoredResult> result;
    bool present = false;
    std::string why_not;  ///< Which outside file changed, where that is why there is no result.

    std::string error;  ///< Of a failed one.
    int error_code = 0;
};

/// What `estimates` say of the stage, its seconds without those that a checkpoint saves.
CostFigures remaining_cost(const StageNode& node, const std::map<std::string, CostFigures>& estimates);

/// Which stages have their results in the store, which must run. Results are asked for from the ends: a stage whose result is
/// gone runs only if something that must run reads it.
class RunState
{
  public:
    /// `until`: that stage and what it needs; empty: all. The pipeline and the store must outlive it.
    RunState(const Pipeline& pipeline, const Store& store, FileHashes& hashes, const std::string& until);

    std::vector<StageNode>& nodes() { return nodes_; }
    const std::vector<StageNode>& nodes() const { return nodes_; }
    StageNode* find(std::string_view stage);

    /// Looks at the store anew and sets the states of all stages that are not running, failed or interrupted.
    void update();
    /// Whether all producers' results are there.
    bool ready(const StageNode& node) const;

  private:
    void resolve(StageNode& node);

    const Store& store_;
    FileHashes& hashes_;
    std::vector<StageNode> nodes_;
    std::string until_;
};

}  // namespace fresco::host
