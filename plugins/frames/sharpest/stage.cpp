#include "blur.h"
#include "selection.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/images/sharpness.h>
#include <fresco/parallel.h>
#include <fresco/stage.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sharpest = fresco::sharpest;

namespace
{

class FramesSharpest final : public fresco::Stage
{
    fresco::Input<fresco::Frames> frames{this, "frames", "Recorded frames"};
    fresco::Output<fresco::Frames> sharp{this, "frames", "The sharp frames, in the same order"};
    fresco::Option<std::string> measure{this, "measure", "blur", fresco::one_of({"blur", "laplacian_variance"}),
                                        "blur: detail lost beside other frames of the same surface; laplacian_variance: as in "
                                        "StyleMesh, also drops sharp frames of "
                                        "plain surfaces"};
    fresco::Option<double> max_blur_px{
        this, "max_blur_px", 3, fresco::range(0, 100),
        "For measure: blur: drop frames blurred by more than this many pixels of a picture 480 px high"};
    fresco::Option<double> min_sharpness{this, "min_sharpness", 150.0, fresco::at_least(0),
                                         "For measure: laplacian_variance: drop frames below this; 0: keep all"};
    fresco::Option<int> window_count{this, "window_count", 1, fresco::range(1, 1'000'000),
                                     "Keep the sharpest of this many consecutive frames of a sequence; 1: keep all"};
    fresco::Option<int> max_frames{this, "max_frames", 0, fresco::range(0, 10'000'000),
                                   "Maximum number of frames: the sharpest of as many equal stretches; 0: no limit"};
    fresco::Option<int> hold_out_every{this, "hold_out_every", 0, fresco::range(0, 1'000'000),
                                       "Set one of this many kept frames aside to judge the result on; 0: none"};
    fresco::Option<bool> held_out{this, "held_out", false, "With hold_out_every: pass on the frames set aside, not the others"};
    fresco::Slot<fresco::ImageIo> images{this, "Reads and writes pictures"};

    bool compares() const { return *measure == "blur"; }
    /// The least sharpness of a frame that is kept; sharpness is negative blur where frames are compared.
    double threshold() const { return compares() ? -*max_blur_px : *min_sharpness; }

    void run(fresco::RunContext& run) override
    {
        if (*held_out && *hold_out_every == 0)
            throw fresco::Error("option \"held_out\" needs frames to be set aside: set hold_out_every, too");
        const auto measured = compares() ? compared(run) : measured_by_laplacian(run);
        auto selection =
            select_frames(measured, {.min_sharpness = threshold(), .window_count = *window_count, .max_frames = *max_frames});
        if (*hold_out_every > 0)
            split(selection, run);
        fresco::Frames kept;
        kept.offset_m = frames->offset_m;
        for (const auto i : selection.kept)
            kept.frames.push_back(frames->frames[i]);
        report(measured, selection, run);
        sharp = std::move(kept);
    }

    /// Leaves the frames of one side: of every hold_out_every frames, the middle one is held out.
    void split(Selection& selection, fresco::RunContext& run) const
    {
        const auto every = static_cast<std::size_t>(*hold_out_every);
        std::vector<std::size_t> sides[2];
        for (std::size_t i = 0; i < selection.kept.size(); ++i)
            sides[i % every == every / 2 ? 1 : 0].push_back(selection.kept[i]);
        run.report("training", sides[0].size());
        run.report("held_out", sides[1].size());
        if (sides[0].empty() || sides[1].empty())
            throw fresco::Error(
                fmt::format("option \"hold_out_every\": {} of {} frames would be held out; set it to 2 or more, and to "
                            "less than twice the number of frames",
                            sides[1].size(), selection.kept.size()));
        selection.kept = std::move(sides[*held_out ? 1 : 0]);
    }

    std::vector<MeasuredFrame> measured_by_laplacian(fresco::Progress& progress) const
    {
        const auto& all = frames->frames;
        std::vector<MeasuredFrame> measured(all.size());
        fresco::parallel_for_each(all.size(), "frames", progress,
                                  [&](std::size_t i)
                                  {
                                      const auto picture = fresco::load_color(all[i], images.get().get());
                                      measured[i] = {all[i].sequence, all[i].name, fresco::usual_sharpness(picture)};
                                  });
        return measured;
    }

    sharpest::BlurView view_of(const fresco::Frame& frame) const
    {
        const std::string name = " camera of " + frame.sequence + "/" + frame.name;
        fresco::check_camera(frame.color, "the color" + name);
        sharpest::BlurView view{frame.sequence, sharpest::detail_of(fresco::load_color(frame, images.get().get())), {}};
        if (!frame.depth_picture.empty())
        {
            fresco::check_camera(frame.depth, "the depth" + name);
            view.surface = {fresco::load_depth(frame, images.get().get()), frame.depth, frame.color, view.detail};
        }
        return view;
    }

    std::vector<MeasuredFrame> compared(fresco::Progress& progress) const
    {
        const auto& all = frames->frames;
        std::vector<sharpest::BlurView> views(all.size());
        fresco::parallel_for_each(all.size(), "frames", progress, [&](std::size_t i) { views[i] = view_of(all[i]); });
        const std::vector<double> blur = sharpest::blur_px(views, progress);
        std::vector<MeasuredFrame> measured;
        std::vector<bool> passes;
        for (std::size_t i = 0; i < all.size(); ++i)
        {
            measured.push_back({all[i].sequence, all[i].name, -blur[i]});
            passes.push_back(blur[i] <= *max_blur_px);
        }
        for (const std::size_t i : sharpest::needed_views(views, blur, passes, progress))
            measured[i].is_needed = true;
        return measured;
    }

    /// In the form that the run's report draws.
    fresco::Value judged(const std::vector<MeasuredFrame>& measured, const Selection& selection) const
    {
        using fresco::Value;
        Value::List names;
        Value::List values;
        Value::List beyond;
        Value::List kept(measured.size(), Value(false));
        for (const MeasuredFrame& frame : measured)
        {
            names.emplace_back(frame.sequence + "/" + frame.name);
            values.emplace_back(std::abs(frame.sharpness));
            beyond.emplace_back(!passes(frame, threshold()));
        }
        for (const std::size_t i : selection.kept)
            kept[i] = true;
        return Value::Map{{"measure", compares() ? "blur in pixels" : "sharpness"},
                          {compares() ? "most" : "least", std::abs(threshold())},
                          {"names", std::move(names)},
                          {"values", std::move(values)},
                          {"beyond", std::move(beyond)},
                          {"kept", std::move(kept)}};
    }

    void report(const std::vector<MeasuredFrame>& measured, const Selection& selection, fresco::RunContext& run) const
    {
        const auto [least, most] = std::ranges::minmax(measured, {}, &MeasuredFrame::sharpness);
        const auto needed = std::ranges::count_if(measured, &MeasuredFrame::is_needed);
        run.report("frames", measured.size());
        run.report("kept", selection.kept.size());
        run.report("dropped_blurred", selection.blurred);
        run.report("dropped_less_sharp_in_window", selection.less_sharp);
        run.report("dropped_beyond_max_frames", selection.beyond_limit);
        if (compares())
        {
            run.report("kept_although_blurred", static_cast<std::size_t>(needed));
            run.report("most_blur_px", -least.sharpness);
        }
        else
        {
            run.report("least_sharpness", least.sharpness);
            run.report("most_sharpness", most.sharpness);
        }
        run.report("judged_frames", judged(measured, selection));
        const std::size_t other_side =
            measured.size() - selection.kept.size() - selection.blurred - selection.less_sharp - selection.beyond_limit;
        run.message(
            fmt::format("{} of {} frames kept; dropped: {} blurred, {} beside a sharper one, {} beyond max_frames{}",
                        selection.kept.size(), measured.size(), selection.blurred, selection.less_sharp, selection.beyond_limit,
                        *hold_out_every == 0 ? "" : fmt::format("; {} {}", other_side, *held_out ? "not held out" : "held out")));
        if (needed > 0)
            run.message(std::to_string(needed) + " blurred frames are kept because no other frame sees some of their surface");
    }
};

}  // namespace

FRESCO_STAGE("frames.sharpest", FramesSharpest, "Drops blurred frames and keeps the sharpest of each window")
