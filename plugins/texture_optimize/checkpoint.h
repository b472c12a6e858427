#pragma once

#include "held_out.h"

#include <fresco/image.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>

#include <cstdint>
#include <filesystem>
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

    /// Refers to the tensors, copies nothing.
    static Checkpoint of(std::int64_t step, std::int64_t rollbacks, const std::vector<TextureParameter>& parameters,
                         const OptimizerRule& rule, const std::map<std::string, std::shared_ptr<Loss>>& losses,
                         const Raster8& seen);

    /// One safetensors file, written whole or not at all.
    void write(const std::filesystem::path& file) const;
    /// Nothing where there is no file. Throws Error for a file that is damaged or of another form.
    static std::optional<Checkpoint> read(const std::filesystem::path& file);

    /// Puts everything back. Throws Error where it does not fit.
    void restore(std::vector<TextureParameter>& into, OptimizerRule& into_rule,
                 const std::map<std::string, std::shared_ptr<Loss>>& into_losses) const;
};

}  // namespace fresco::optimize
