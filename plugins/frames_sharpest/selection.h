#pragma once

#include <cstddef>
#include <string>
#include <vector>

/// A frame as far as its choice is concerned.
struct MeasuredFrame
{
    std::string sequence;
    std::string name;
    double sharpness = 0;
    bool is_needed = false;  ///< Passes however blurred it is.
};

struct SelectionOptions
{
    double min_sharpness;
    int window_count;  ///< Of this many consecutive frames of a sequence the sharpest is kept; 1 keeps all.
    int max_frames;    ///< Of more frames, the sharpest of each of this many equal stretches is kept; 0 = no limit.
};

struct Selection
{
    std::vector<std::size_t> kept;  ///< Indices in the order of the frames.
    std::size_t blurred = 0;        ///< Dropped: below min_sharpness, and not needed.
    std::size_t less_sharp = 0;     ///< Dropped: a sharper frame is in the same window.
    std::size_t beyond_limit = 0;   ///< Dropped: more than max_frames.
};

/// Chooses frames; equally sharp ones: the first. Windows are cut from the recorded frames, blurred ones included, so that the
/// kept ones stay evenly spread. Throws Error if there are no frames, or if none passes: then it names the thresholds that one
/// frame and half of the frames would pass.
Selection select_frames(const std::vector<MeasuredFrame>& frames, const SelectionOptions& options);
