#pragma once

#include <fresco/recording.h>

#include <filesystem>
#include <vector>

/// What a scan in the layout of 7-Scenes consists of, in recorded order.
struct ScanFolder
{
    std::vector<std::filesystem::path> sequences;  ///< The folders seq-XX that are used.
    std::vector<fresco::ViewFiles> frames;
};

/// Lists `path`/seq-XX/frame-XXXXXX.{color.png or color.jpg, depth.png, pose.txt}, sequences and frames by number.
/// \param sequences  numbers of the sequences to take; empty: all
/// \param every      of each sequence, every `every`-th frame, from its first on; >= 1
/// Throws MissingInput if there are no sequences, no frames, or frames without one of their three files (the first ones are
/// named); Error if a frame has two color pictures.
ScanFolder list_scan(const std::filesystem::path& path, const std::vector<int>& sequences, int every);
