#pragma once

#include "checkpoint.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace fresco::optimize
{

/// The checkpoints of a run on disk: the last two that were due, and one of an interruption or kept for a kill. Where a run goes
/// back to depends only on those that were due, so that an interruption changes nothing.
class CheckpointFolder
{
  public:
    explicit CheckpointFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Tries to use a checkpoint; throws Error where it does not fit.
    using Use = std::function<void(const Checkpoint&)>;
    using Warn = std::function<void(const std::string&)>;

    enum class Used
    {
        none,
        interrupted,
        due,
        earlier
    };
    /// To go on: the interruption's, else the last one due. Each that cannot be used is named to `warn`.
    Used use_latest(const Use& use, const Warn& warn) const;
    /// To go back: the last one due before `step`, whose evaluation failed; those from `step` on are thrown away. The state of a
    /// step is known to be good once the step was evaluated. The interruption's is thrown away. False where none is left.
    bool use_before(std::int64_t step, const Use& use, const Warn& warn) const;

    /// The one that was due before is kept as well; the interruption's is no longer needed.
    void write_due(const Checkpoint& checkpoint) const;
    void write_interrupted(const Checkpoint& checkpoint) const;

  private:
    std::filesystem::path due() const { return folder_ / "checkpoint.safetensors"; }
    std::filesystem::path earlier() const { return folder_ / "earlier.safetensors"; }
    std::filesystem::path interrupted() const { return folder_ / "interrupted.safetensors"; }

    std::filesystem::path folder_;
};

}  // namespace fresco::optimize
