#pragma once

#include "run/run_state.h"

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// \file What a person sees of a run on a terminal, as text. Knows nothing of terminals and clocks.

namespace fresco::host
{

/// A name and what it came to; nothing: not finite.
using Metric = std::pair<std::string, std::optional<double>>;

/// "loss 0.25", "loss not finite"
std::string metric_text(const Metric& metric);

/// Counts and measurements of a stage.
struct Count
{
    double done = 0;
    double total = 0;  ///< 0: unknown.
    std::string unit;  ///< Empty: it has not reported any progress.
    double rate = 0;   ///< Units per second; 0: unknown.
    std::vector<Metric> metrics;

    /// "120 of 400 steps"; a short count names the one in work: "round 3 of 10".
    std::string count_text() const;
    /// "1.9 steps/s"
    std::string rate_text() const;
};

struct ViewStage : Count
{
    std::string name;
    StageState state = StageState::waiting;
    bool waits = false;     ///< Running, but another run makes the result.
    int threads = 0;        ///< Threads of a running stage.
    double seconds = 0;     ///< Time that it took, or has been running for.
    double expected_s = 0;  ///< By its own account, as earlier runs corrected it; 0: unknown.
    std::string preview;    ///< Path of its newest picture; empty: none.
    std::string holder;     ///< Run that makes the result; empty: unknown.
};

struct ViewFrame
{
    std::size_t width = 80;   ///< columns
    std::size_t height = 24;  ///< lines
    bool utf8 = true;
    bool color = false;
    int cores = 1;
    double seconds = 0;  ///< Time of the whole run, so far.
};

/// How long a running or waiting stage still takes: its count's speed, trusted the more the further it is, and what it is
/// expected to take. Nothing if neither is known.
std::optional<double> left_s(const ViewStage& stage);
/// How long all still takes, stages side by side sharing the cores. Nothing if it is not known of any stage.
std::optional<double> left_s(const std::vector<ViewStage>& stages, int cores);

/// The lines, without line ends, each at most width - 1 columns wide, at most height - 1 of them: a line per stage in their
/// order, what a running one counts, its loss and its picture, and one line for the whole run. Where there is no room for all,
/// first the details go, then finished and waiting stages are counted in a line.
std::vector<std::string> draw_view(const std::vector<ViewStage>& stages, const ViewFrame& frame);

}  // namespace fresco::host
