#include "loop.h"

#include <fresco/frames.h>
#include <fresco/option.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <ATen/Context.h>
#include <torch/version.h>

#include <string>

using namespace fresco;
using namespace fresco::optimize;

namespace
{

enum class Device
{
    automatic,  ///< CUDA where libtorch finds it.
    cpu,
    cuda
};

torch::Device chosen_device(Device wanted)
{
    if (wanted == Device::cuda && !at::hasCUDA())
        throw Error("option \"device\": cuda is not available: this libtorch (" TORCH_VERSION
                    ") finds no CUDA device; set cpu or auto, or build with a CUDA libtorch");
    if (wanted == Device::cpu || !at::hasCUDA())
        return torch::kCPU;
    // float32 shall be float32; a network has an option for less.
    at::globalContext().setAllowTF32CuDNN(false);
    at::globalContext().setAllowTF32CuBLAS(false);
    // Sheets have many shapes: to time every algorithm for each of them would take longer than the best one saves.
    at::globalContext().setBenchmarkCuDNN(false);
    return {torch::kCUDA, 0};
}

class TextureOptimize final : public Stage
{
    Input<UvMaps> uvmaps{this, "uvmaps", "Which texel each pixel of each view sees"};
    Input<Frames> frames{this, "frames", "The frames that the uv maps were made for, with their color pictures"};
    Input<Image> style{this, "style", "Style picture"};
    Input<Texture> start{this, "start", optional,
                         "With init: frames, the texture to recolor and start from (not wired: colors of the pictures); and what "
                         "frames without pictures show"};
    Output<Texture> texture{this, "texture", "The optimized texture, layer by layer"};

    Choice<Protocol> protocol{this,
                              "protocol",
                              Protocol::paper,
                              {{"paper", Protocol::paper},
                               {"released_scannet", Protocol::released_scannet},
                               {"released_matterport3d", Protocol::released_matterport3d}},
                              "Where they differ: as StyleMesh's paper has it, or as its authors' released code does, with its "
                              "loader for either dataset"};
    Option<int> size_px{this, "size_px", 0, range(0, 16384),
                        "Texels per side, a multiple of 8 for the default texture; 0: as the uv maps say, which have it "
                        "from the atlas"};
    Option<std::vector<int>> heights_px{this, "heights_px", std::vector<int>{}, at_least(1),
                                        "Heights of the uv maps to render, each a level; empty: all"};
    Option<int> epochs{this, "epochs", 2, range(1, 100000), "Number of visits to every view"};
    Option<int> repeats_count{this, "repeats_count", 8, range(1, 100000), "Consecutive steps on a view at each visit"};
    Option<std::int64_t> max_steps{this, "max_steps", 0, at_least(0), "Maximum number of steps; 0: no limit"};
    Option<std::int64_t> stop_at_step{
        this, "stop_at_step", 0, at_least(0),
        "End after this step, at the rates of the whole run, and from its checkpoint if there is one; "
        "0: all steps"};
    Option<double> rate{this, "rate", 0.02, range(0, 1e6), "Learning rate, in units of `values`"};
    Choice<Decay> decay{this,
                        "decay",
                        Decay::cosine,
                        {{"cosine", Decay::cosine}, {"step", Decay::step}},
                        "cosine: full rate for decay_start, then down to 0; step: a tenth of it after every three epochs"};
    Option<double> decay_start{this, "decay_start", 0.5, range(0, 1), "With decay cosine: share of the steps at the full rate"};
    Choice<Values> values{this,
                          "values",
                          Values::display,
                          {{"display", Values::display}, {"network", Values::network}},
                          "Stored values: RGB in [0,1], or BGR in 0..255 minus the network's mean"};
    Choice<Init> init{this,
                      "init",
                      Init::frames,
                      {{"frames", Init::frames}, {"zeros", Init::zeros}, {"color", Init::color}, {"noise", Init::noise}},
                      "Start from: recolored pictures (or start), zeros, the style's mean color, or noise around it"};
    Option<double> lambda_r{this, "lambda_r", 0, at_least(0),
                            "λ_r in the regularizer λ_r Σ k_i mean(layer_i²); the paper: 5000, in network units"};
    Choice<GradientScaling> gradient_scaling{
        this,
        "gradient_scaling",
        GradientScaling::angle,
        {{"none", GradientScaling::none}, {"level", GradientScaling::level}, {"angle", GradientScaling::angle}},
        "Multiply each pixel's gradient by the level's share in it (level), and by the "
        "cosine between normal and view (angle)"};
    Option<bool> depth_levels{this, "depth_levels", false,
                              "Show each pixel only at the heights that fit its depth, so that patterns keep one size in "
                              "the world"};
    Option<double> theta_d_m{this, "theta_d_m", 0.25, range(0.001, 1000),
                             "θ_d: ideal height = 32 px · depth / theta_d_m; smaller for short-range scans"};
    Option<double> angle_limit_deg{this, "angle_limit_deg", 90, range(0, 90),
                                   "Largest angle between normal and view for the fine style; 90: all pixels"};
    Option<int> held_out_count{this, "held_out_count", 0, range(0, 16),
                               "Number of evenly spread views to measure the losses on instead of optimizing"};
    Option<double> stop_gain{
        this, "stop_gain", 0, range(0, 0.99),
        "With held_out_count: stop when three measurements have not lowered the loss by this share; 0: run all steps"};
    Option<std::int64_t> seed{this, "seed", 0, at_least(0),
                              "Seed of the views' order, of the losses' sampling and of the noise of `init: noise`"};
    Choice<Device> device{this,
                          "device",
                          Device::automatic,
                          {{"auto", Device::automatic}, {"cpu", Device::cpu}, {"cuda", Device::cuda}},
                          "Where losses are computed",
                          chooses_device};
    // In the key: where a run goes back to after a loss that is not finite depends on it.
    Option<int> checkpoint_steps{this, "checkpoint_steps", 200, at_least(0),
                                 "Steps between two checkpoints that a run may roll back to; 0: none"};

    SlotMap<Loss> losses{this, "losses", "", "Losses on the rendered views"};
    Slot<TextureRepresentation> representation{this, "texture", "texture.laplacian", "How the texture is stored"};
    Slot<OptimizerRule> optimizer{this, "optimizer",
                                  R"({"type": "optimizer.adam", "mode": "visible", "beta1": 0.9, "beta2": 0.99})",
                                  "How a step changes the texture"};
    Slot<ImageIo> images{this, optional, "Reads pictures that are not NPY, writes previews; none: only NPY, no previews"};

  public:
    void run(RunContext& run) override
    {
        if (losses->empty())
            throw Error("option \"losses\" is empty; set at least one");
        if (*stop_gain > 0 && *held_out_count == 0)
            throw Error("option \"stop_gain\" needs held-out views; set held_out_count too");
        constexpr const char* source = "the uv maps on port 'uvmaps'";
        const auto options = loop_options(painted_size_px(*size_px, uvmaps->texture_px, source, run));
        check_uv_bits(*uvmaps, options.size_px, source);
        run.report("device", options.device.is_cuda() ? "cuda" : "cpu");
        if (start.has_value() && !start->atlas.empty() && !uvmaps->atlas.empty() && start->atlas != uvmaps->atlas)
            throw Error("the texture on port 'start' was made for another atlas than the uv maps on port 'uvmaps': wire a "
                        "texture of the same atlas");
        Texture result = optimized_texture(
            {*uvmaps, *frames, style->pixels, start.has_value() ? &*start : nullptr},
            {*losses, *representation, *optimizer, images.has_value() ? images.get().get() : nullptr}, options, run);
        result.atlas = uvmaps->atlas;
        texture = std::move(result);
    }

    /// StyleMesh's sizes; the features of camera pictures take up to 2 GB of it.
    double memory_mb() const override { return 5000; }

  private:
    LoopOptions loop_options(int size) const
    {
        return {.size_px = size,
                .heights_px = *heights_px,
                .values = *values,
                .init = *init,
                .levels = {.protocol = *protocol,
                           .by_depth = *depth_levels,
                           .theta_d_m = *theta_d_m,
                           .angle_limit_deg = *angle_limit_deg,
                           .scaling = *gradient_scaling},
                .lambda_r = *lambda_r,
                .seed = static_cast<std::uint64_t>(*seed),
                .device = chosen_device(*device),
                .schedule = {.epochs = *epochs,
                             .repeats_count = *repeats_count,
                             .max_steps = *max_steps,
                             .shuffled = *protocol == Protocol::paper,
                             .rate = *rate,
                             .decay = *decay,
                             .decay_start = *decay_start},
                .held_out_count = *held_out_count,
                .stop_gain = *stop_gain,
                .stop_at_step = *stop_at_step,
                .checkpoint_steps = *checkpoint_steps};
    }
};

}  // namespace

FRESCO_STAGE("texture.optimize", TextureOptimize, "Optimizes a texture so that its views have a picture's style")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
