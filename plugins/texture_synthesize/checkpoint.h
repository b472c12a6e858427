#pragma once

#include "search.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace fresco::synthesize
{

/// Where a synthesis stands after a round.
struct Checkpoint
{
    int level = 0;
    int rounds = 0;  ///< Of this level that are done.
    std::vector<Vec3f> colors;
    std::vector<Match> matches;
    std::vector<float> crowding;
};

/// Writes it whole or not at all, with a checksum. Throws Error naming the file.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);
/// Nothing without a checkpoint. Throws Error naming the file if it is damaged.
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& file);

}  // namespace fresco::synthesize
