#pragma once

#include <string>
#include <vector>

namespace fresco
{

/// How many there are of something: one of `number`, `option`, `squares_of` and `files`, or, where none is set, what the inputs
/// bring (for steps: their frames); then times, divided and limited. Options are named as in a pipeline file.
struct CostSize
{
    double number = 0;
    std::string option{};      ///< The number in this option.
    std::string squares_of{};  ///< The square of this option, or the sum of the squares of its list; of pixels: times 4/3.
    std::string files{};       ///< The files below the folder in this option whose paths match `pattern`: "images/*".
    std::string pattern{};
    double bytes_each = 0;                  ///< Of `files`: their bytes, divided by this, instead of their number.
    std::vector<std::string> times{};       ///< Options.
    std::vector<std::string> divided_by{};  ///< Options.
    std::string at_most{};                  ///< An option; 0 in it: no limit.

    friend bool operator==(const CostSize&, const CostSize&) = default;
};

/// What one of each takes; all of it is added up. Numbers are finite and at least 0.
struct CostRates
{
    double fixed = 0;
    double per_core = 0;  ///< Of memory: what every thread holds.
    double per_frame = 0;
    double per_face = 0;
    double per_texel = 0;
    double per_pixel = 0;  ///< Of a frame, all heights together. Seconds and disk count every frame (or step), memory one.
    double per_step = 0;
};

/// About what a stage costs, for `fresco plan`: right within a factor of two is good enough, since earlier runs on the machine
/// correct it. Plain data, so that the host needs no library for it: it knows the sizes and multiplies.
struct Cost
{
    CostRates seconds{};        ///< On one core.
    double parallel_share = 0;  ///< Of the seconds: the share that all cores work on, 0 to 1.
    CostRates memory_mb{.fixed = 20};
    CostRates disk_mb{};

    /// Where the stage does not pass on its inputs' sizes; the stages behind it count by these. Disk counts what the stage makes.
    /// Seconds and memory count the frames and faces that come in, or that it makes where none come in; the texels and pixels are
    /// always those it makes.
    CostSize frames{};
    CostSize faces{};
    CostSize texels{};  ///< Of the texture: {.squares_of = "size_px"}.
    CostSize pixels{};  ///< Of a frame's pictures or uv maps: {.squares_of = "heights_px"}.
    CostSize steps{};   ///< Of its own work, passed on to nobody.

    /// The option that says whether the stage works on a GPU: true, or the device "cuda". Its "auto" becomes "cuda" or "cpu"
    /// before anything runs, so that the key of a result says where it was made. Empty: never.
    std::string device{};
};

}  // namespace fresco
