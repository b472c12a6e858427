#pragma once

#include <fresco/evaluation/protocol.h>

#include <cstddef>
#include <string>
#include <vector>

using fresco::evaluation::Protocol;

/// A frame's place in its recording.
struct FramePlace
{
    std::string sequence;
    long number = 0;  ///< The recorder's frame number.
};

struct FramePair
{
    std::size_t source = 0;
    std::size_t target = 0;
    friend bool operator==(const FramePair&, const FramePair&) = default;
};

/// Pairs within a sequence, in the order of their sources. `paper`: the target's recorded number is the source's plus `gap`, and
/// a source without one is left out. `released`: the target stands `gap` list positions before the source, or else that many
/// behind it; otherwise the frame has no pair. Indices into `frames`. \pre gap > 0
std::vector<FramePair> frame_pairs(const std::vector<FramePlace>& frames, long gap, Protocol protocol);

/// The smallest difference of recorded numbers within a sequence; 0 if there is none.
long smallest_gap(const std::vector<FramePlace>& frames);
