#pragma once

/// \file The state of a run on disk, so that a killed or interrupted run ends with the same bytes, and one whose loss is not
/// finite goes back. For loop.cpp.

#include "evaluation.h"

#include <fresco/image.h>
#include <fresco/run_context.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fresco::optimize
{

/// All that a run needs to go on with the same bytes.
struct Checkpoint
{
    std::int64_t step = 0;       ///< Steps done.
    std::int64_t rollbacks = 0;  ///< How often a loss was not finite and the run went back.
    TensorMap parameters;        ///< By the parameters' names.
    TensorMap rule;
    std::map<std::string, TensorMap> losses;
    Raster8 seen;
    std::vector<HeldOutLoss> held_out;  ///< Measured so far.

    /// With tensors of its own.
    Checkpoint copied() const;
    /// One safetensors file, written whole or not at all.
    void write(const std::filesystem::path& file) const;
    /// Returns nothing if there is no file. Throws Error for a file that is damaged or of another form.
    static std::optional<Checkpoint> read(const std::filesystem::path& file);

    /// Puts everything back. Throws Error where it does not fit.
    void restore(std::vector<TextureParameter>& into, OptimizerRule& into_rule,
                 const std::map<std::string, std::shared_ptr<Loss>>& into_losses) const;
};

/// The checkpoints of a run on disk: the last two that were due, and one of an interruption or kept for a kill. Where a run goes
/// back to depends only on those that were due, so that an interruption changes nothing.
class CheckpointFolder
{
  public:
    explicit CheckpointFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Tries to use a checkpoint; throws Error where it does not fit.
    using Use = std::function<void(const Checkpoint&)>;

    enum class Used
    {
        none,
        interrupted,
        due,
        earlier
    };
    /// To go on: the interruption's, else the last one due, of those not after `last`. Warns of each that cannot be used.
    Used use_latest(std::int64_t last, const Use& use, RunContext& run) const;
    /// To go back: the last one due before `step`, whose evaluation failed; those from `step` on are thrown away. The state of a
    /// step is known to be good once the step was evaluated. The interruption's is thrown away. False where none is left.
    bool use_before(std::int64_t step, const Use& use, RunContext& run) const;

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
