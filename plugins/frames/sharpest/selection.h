#pragma once

#include <cstddef>
#include <string>
#include <vector>

/// \file Chooses the sharpest frames of a recording, for the stage.

/// The data of a frame for the choice.
struct MeasuredFrame
{
    std::string sequence;
    std::string name;
    double sharpness = 0;
    bool is_needed = false;  ///< Passes regardless of its blur.
};

struct SelectionOptions
{
    double min_sharpness;
    int window_count;  ///< Keep the sharpest of this many consecutive frames of a sequence; 1 keeps all.
    int max_frames;    ///< Keep at most this many frames: the sharpest of each of as many equal stretches; 0 = no limit.
};

/// Whether a frame is not dropped for its own sake; another may still be kept in its place.
inline bool passes(const MeasuredFrame& frame, double min_sharpness)
{
    return frame.is_needed || frame.sharpness >= min_sharpness;
}

struct Selection
{
    std::vector<std::size_t> kept;  ///< Indices in the order of the frames.
    std::size_t blurred = 0;        ///< Dropped: below min_sharpness, and not needed.
    std::size_t less_sharp = 0;     ///< Dropped: a sharper frame is in the same window.
    std::size_t beyond_limit = 0;   ///< Dropped: more than max_frames.
};

/// Chooses frames; the first of equally sharp ones. Windows are cut from the recorded frames, blurred ones included, so that the
/// kept ones stay evenly spread. Throws Error if there are no frames, or if none passes; the latter names the thresholds that
/// one frame and half of the frames would pass.
Selection select_frames(const std::vector<MeasuredFrame>& frames, const SelectionOptions& options);
