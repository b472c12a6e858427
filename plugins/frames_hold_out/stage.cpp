#include <fresco/frames.h>
#include <fresco/stage.h>

#include <fmt/format.h>

namespace
{

class FramesHoldOut final : public fresco::Stage
{
    fresco::Input<fresco::Frames> frames{this, "frames", "Posed frames"};
    fresco::Output<fresco::Frames> training{this, "training", "The frames to optimize with"};
    fresco::Output<fresco::Frames> held_out{this, "held_out", "The frames to judge the result on"};
    fresco::Option<int> every_count{this, "every_count", 12, fresco::range(2, 1'000'000), "Hold out one of this many frames"};
    fresco::Option<int> first_count{this, "first_count", 6, fresco::range(0, 1'000'000), "Frames before the first held-out one"};

    void run(fresco::RunContext& run) override
    {
        fresco::Frames kept;
        fresco::Frames rest;
        for (std::size_t i = 0; i < frames->frames.size(); ++i)
        {
            const auto position = static_cast<long>(i) - *first_count;
            (position >= 0 && position % *every_count == 0 ? rest : kept).frames.push_back(frames->frames[i]);
        }
        if (kept.frames.empty() || rest.frames.empty())
            throw fresco::Error(fmt::format("{} of {} frames would be held out; lower first_count, or use more frames",
                                            rest.frames.size(), frames->frames.size()));
        run.report("training", kept.frames.size());
        run.report("held_out", rest.frames.size());
        training = std::move(kept);
        held_out = std::move(rest);
    }
};

}  // namespace

FRESCO_STAGE("frames.hold_out", FramesHoldOut, "Sets frames aside to judge a result on views it was not made from")
