#pragma once

#include "search.h"

#include <filesystem>
#include <optional>
#include <vector>

/// \file Saves the state of a synthesis, so that an interrupted run resumes with the same result. The synthesis writes
/// checkpoints; the fuzzer reads damaged ones. Apart from the synthesis because it parses a file.

namespace fresco::synthesize
{

/// The state of a synthesis after a round. The colors follow from it.
struct Checkpoint
{
    int level = 0;
    int rounds = 0;  ///< Finished rounds of this level.
    std::vector<Match> matches;
    std::vector<float> crowding;
};

/// Writes atomically, with a checksum. Throws Error naming the file.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);
/// nullopt if the file does not exist. Throws Error naming the file if it is damaged.
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& file);

}  // namespace fresco::synthesize
