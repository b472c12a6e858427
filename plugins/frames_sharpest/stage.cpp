#include "selection.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/images/sharpness_option.h>
#include <fresco/parallel.h>
#include <fresco/stage.h>

#include <algorithm>
#include <atomic>

namespace
{

class FramesSharpest final : public fresco::Stage
{
    fresco::Input<fresco::Frames> frames{this, "frames", "Recorded frames"};
    fresco::Output<fresco::Frames> sharp{this, "frames", "The sharp frames, in the same order"};
    fresco::Option<double> min_sharpness{this, "min_sharpness", 150.0, fresco::at_least(0),
                                         "Drop frames whose variance of the Laplacian is below this; 0: keep all"};
    fresco::SharpnessOption sharpness{this};
    fresco::Option<int> window_count{this, "window_count", 1, fresco::range(1, 1'000'000),
                                     "Keep the sharpest of this many consecutive frames of a sequence; 1: keep all"};
    fresco::Option<int> max_frames{this, "max_frames", 0, fresco::range(0, 10'000'000),
                                   "Maximum number of frames: the sharpest of as many equal stretches; 0: no limit"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reads and writes pictures"};

    void run(fresco::RunContext& run) override
    {
        sharpness.check();
        const auto measured = measure(run);
        const auto selection =
            select_frames(measured, {.min_sharpness = *min_sharpness, .window_count = *window_count, .max_frames = *max_frames});
        fresco::Frames kept;
        for (const auto i : selection.kept)
            kept.frames.push_back(frames->frames[i]);
        report(measured, selection, run);
        sharp = std::move(kept);
    }

    std::vector<MeasuredFrame> measure(fresco::Progress& progress) const
    {
        const auto& all = frames->frames;
        std::vector<MeasuredFrame> measured(all.size());
        std::atomic<std::size_t> done{0};
        fresco::parallel_for(all.size(), 1, progress.threads(),
                             [&](std::size_t begin, std::size_t end)
                             {
                                 for (std::size_t i = begin; i < end; ++i)
                                 {
                                     progress.check_canceled();
                                     const auto picture = fresco::load_color(all[i], images.get().get());
                                     measured[i] = {all[i].sequence, all[i].name, sharpness.of(picture)};
                                     progress.progress(static_cast<double>(++done), static_cast<double>(all.size()), "frames");
                                 }
                             });
        return measured;
    }

    /// In the form that the run's report draws.
    fresco::Value judged(const std::vector<MeasuredFrame>& measured, const Selection& selection) const
    {
        using fresco::Value;
        Value::List names;
        Value::List values;
        Value::List kept(measured.size(), Value(false));
        for (const MeasuredFrame& frame : measured)
        {
            names.emplace_back(frame.sequence + "/" + frame.name);
            values.emplace_back(frame.sharpness);
        }
        for (const std::size_t i : selection.kept)
            kept[i] = true;
        return Value::Map{{"measure", "sharpness"},
                          {"least", *min_sharpness},
                          {"names", std::move(names)},
                          {"values", std::move(values)},
                          {"kept", std::move(kept)}};
    }

    void report(const std::vector<MeasuredFrame>& measured, const Selection& selection, fresco::RunContext& run) const
    {
        const auto [least, most] = std::minmax_element(measured.begin(), measured.end(),
                                                       [](const auto& a, const auto& b) { return a.sharpness < b.sharpness; });
        run.report("frames", measured.size());
        run.report("kept", selection.kept.size());
        run.report("dropped_blurred", selection.blurred);
        run.report("dropped_less_sharp_in_window", selection.less_sharp);
        run.report("dropped_beyond_max_frames", selection.beyond_limit);
        run.report("least_sharpness", least->sharpness);
        run.report("most_sharpness", most->sharpness);
        run.report("judged_frames", judged(measured, selection));
        run.message(std::to_string(selection.kept.size()) + " of " + std::to_string(measured.size()) + " frames kept; dropped: " +
                    std::to_string(selection.blurred) + " blurred, " + std::to_string(selection.less_sharp) +
                    " beside a sharper one, " + std::to_string(selection.beyond_limit) + " beyond max_frames");
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.per_frame = 0.004},
                .parallel_share = 1,
                .memory_mb = {.fixed = 55, .per_core = 5},
                .frames = {.at_most = "max_frames"}};
    }
};

}  // namespace

FRESCO_STAGE("frames.sharpest", FramesSharpest, "Drops blurred frames and keeps the sharpest of each window")
