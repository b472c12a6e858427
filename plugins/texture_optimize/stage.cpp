#include "default_losses.h"
#include "loop.h"

#include <fresco/frames.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/weights/state_dict.h>

#include <ATen/Context.h>
#include <torch/version.h>

#include <string>

using namespace fresco;
using namespace fresco::optimize;

namespace
{

/// `auto` takes a CUDA device where libtorch finds one.
torch::Device chosen_device(const std::string& wanted)
{
    if (wanted == "cuda" && !at::hasCUDA())
        throw Error("option \"device\": cuda is not available: this libtorch (" TORCH_VERSION
                    ") finds no CUDA device; set cpu or auto, or build with a CUDA libtorch");
    if (wanted == "cpu" || !at::hasCUDA())
        return torch::kCPU;
    // float32 shall be float32; a network has an option for less.
    at::globalContext().setAllowTF32CuDNN(false);
    at::globalContext().setAllowTF32CuBLAS(false);
    // Crops have many shapes: to time every algorithm for each of them would take longer than the best one saves.
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

    Option<int> size_px{this, "size_px", 0, range(0, 16384),
                        "Texels per side, a multiple of 8 for the default texture; 0: as the uv maps say, which have it "
                        "from the atlas"};
    Option<std::vector<int>> heights_px{this, "heights_px", std::vector<int>{}, at_least(1),
                                        "Heights of the uv maps to render, each a level; empty: all"};
    Option<int> epochs{this, "epochs", 2, range(1, 100000), "Number of visits to every view"};
    Option<int> repeats_count{this, "repeats_count", 8, range(1, 100000), "Consecutive steps on a view at each visit"};
    Option<std::int64_t> max_steps{this, "max_steps", 0, at_least(0), "Maximum number of steps; 0: no limit"};
    Option<std::string> order{this, "order", "shuffled", one_of({"shuffled", "recorded"}),
                              "Order of the views in an epoch; shuffled: seeded, and evenly spread over the recording"};
    Option<double> rate{this, "rate", 0.02, range(0, 1e6), "Learning rate, in units of `values`"};
    Option<std::string> decay{
        this, "decay", "cosine", one_of({"cosine", "step"}),
        "cosine: full rate for decay_start, then down to 0; step: multiplied by step_factor every step_epochs"};
    Option<double> decay_start{this, "decay_start", 0.5, range(0, 1), "With decay cosine: share of the steps at the full rate"};
    Option<int> step_epochs{this, "step_epochs", 3, at_least(1), "With decay step: epochs between two drops"};
    Option<double> step_factor{this, "step_factor", 0.1, range(0, 1), "With decay step: factor of each drop"};
    Option<std::string> values{this, "values", "display", one_of({"display", "network"}),
                               "Stored values: RGB in [0,1], or BGR in 0..255 minus the network's mean"};
    Option<std::string> clamp{this, "clamp", "sum", one_of({"sum", "layers"}),
                              "Clamp the sum of the layers at lookup, or the stored values of each layer after every step"};
    Option<std::string> init{this, "init", "frames", one_of({"frames", "zeros", "color", "noise"}),
                             "Start from: recolored pictures (or start), zeros, the style's mean color, or noise around it"};
    Option<double> lambda_r{this, "lambda_r", 0, at_least(0),
                            "λ_r in the regularizer λ_r Σ k_i mean(layer_i²); the paper: 5000, in network units"};
    Option<std::string> gradient_scaling{this, "gradient_scaling", "angle", one_of({"none", "level", "angle"}),
                                         "Multiply each pixel's gradient by the level's share in it (level), and by the "
                                         "cosine between normal and view (angle)"};
    Option<bool> depth_levels{this, "depth_levels", false,
                              "Show each pixel only at the heights that fit its depth, so that patterns keep one size in "
                              "the world"};
    Option<double> theta_d_m{this, "theta_d_m", 0.25, range(0.001, 1000),
                             "θ_d: ideal height = theta_min_px · depth / theta_d_m; smaller for short-range scans"};
    Option<double> theta_min_px{this, "theta_min_px", 32, range(1, 10000),
                                "θ_min: height in pixels of a length θ_d seen from 1 m"};
    Option<std::string> level_weight{
        this, "level_weight", "nearest", one_of({"nearest", "printed"}),
        "Weight of the nearer of two heights: larger the nearer it is (nearest), or the paper's formula (printed)"};
    Option<std::string> level_depth{this, "level_depth", "mesh", one_of({"mesh", "sensor", "sensor_or_lowest"}),
                                    "Depth for the levels; pixels that the sensor did not measure are in no level "
                                    "(sensor) or in the lowest (sensor_or_lowest)"};
    Option<std::string> level_share{this, "level_share", "pixels", one_of({"pixels", "features"}),
                                    "Weight of a level in the sum: its number of pixels, or of cells in each layer"};
    Option<double> angle_limit_deg{this, "angle_limit_deg", 90, range(0, 90),
                                   "Largest angle between normal and view for the fine style; 90: all pixels"};
    Option<std::string> angle_rule{this, "angle_rule", "at_most", one_of({"at_most", "below"}),
                                   "Whether the limit itself passes"};
    Option<std::string> angle_map{this, "angle_map", "own", one_of({"own", "smallest"}),
                                  "Angles at each height, or at the smallest, enlarged"};
    Option<std::string> empty_pixels{this, "empty_pixels", "black", one_of({"black", "corner"}),
                                     "What pixels without a surface show to the losses' networks: black, or the texture's "
                                     "first texel"};
    Option<std::string> content_target{this, "content_target", "own", one_of({"own", "smallest"}),
                                       "Camera features at each height, or at the smallest, enlarged"};
    Option<std::string> style_sizes{this, "style_sizes", "printed", one_of({"printed", "released"}),
                                    "How the fine and the coarse style picture are sized"};
    Option<double> train_share{this, "train_share", 1, range(0.01, 1), "Share of the views to use, the first ones"};
    Option<int> held_out_count{this, "held_out_count", 0, range(0, 16),
                               "Number of evenly spread views to measure the losses on instead of optimizing"};
    Option<int> measure_steps{this, "measure_steps", 50, at_least(1), "With held_out_count: steps between two measurements"};
    Option<double> stop_gain{
        this, "stop_gain", 0, range(0, 0.99),
        "With held_out_count: stop when three measurements have not lowered the loss by this share; 0: run all steps"};
    Option<std::string> execution{this, "execution", "active", one_of({"active", "reference"}),
                                  "active: encode only the parts of a frame with pixels of a level, and the camera "
                                  "picture once per visit; reference: encode everything in every step, for comparison"};
    Option<std::int64_t> seed{this, "seed", 0, at_least(0),
                              "Seed of the views' order, of the losses' sampling and of the noise of `init: noise`"};
    Option<std::string> device{this, "device", "auto", one_of({"auto", "cpu", "cuda"}), "Where losses are computed"};
    Option<InputFile> weights{this, "weights", InputFile{}, formats(weights::file_formats()),
                              "VGG-19 weights for `losses: auto`; empty: losses without a network"};
    // In the key: where a run goes back to after a loss that is not finite depends on it.
    Option<int> checkpoint_steps{this, "checkpoint_steps", 200, at_least(0),
                                 "Steps between two checkpoints that a run may roll back to; 0: none"};
    Option<double> checkpoint_seconds{this,
                                      "checkpoint_seconds",
                                      30,
                                      range(0, 86400),
                                      "Maximum seconds of work lost when a run is killed, at least twenty times the cost "
                                      "of a checkpoint; 0: by checkpoint_steps",
                                      not_in_key};
    Option<int> preview_every{this, "preview_every", 100, at_least(0), "Steps between two preview pictures; 0: none", not_in_key};

    SlotMap<Loss> losses{this, "losses", "auto", "Losses on the rendered views"};
    Slot<TextureRepresentation> representation{this, "texture", "texture.laplacian", "How the texture is stored"};
    Slot<OptimizerRule> optimizer{this, "optimizer",
                                  R"({"type": "optimizer.adam", "mode": "visible", "beta1": 0.9, "beta2": 0.99})",
                                  "How a step changes the texture"};
    Slot<ImageIo> images{this, "images", "image.opencv", optional,
                         "Reads pictures that are not NPY, writes previews; none: only NPY, no previews"};

  public:
    TextureOptimize() { losses.auto_rule("weights", losses_without_weights, losses_with_weights); }

    void run(RunContext& run) override
    {
        if (losses->empty())
            throw Error("option \"losses\" is empty; set at least one, or remove the option");
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

    Cost cost() const override
    {
        return {.seconds = {.fixed = 2, .per = {{count::frames, 0.03}, {count::pixels, 2.5e-6}}},
                .parallel_share = 1,
                .memory_mb = {.fixed = 400, .per = {{count::texels, 4e-5}, {count::pixels, 1.1e-3}}},
                .disk_mb = {.per = {{count::texels, 1.7e-5}}},
                .makes = {{count::texels, {.squares_of = "size_px"}}, {count::pixels, {.squares_of = "heights_px"}}},
                .steps = {.brought = count::frames, .times = {"epochs", "repeats_count"}, .at_most = "max_steps"},
                .device = "device"};
    }

  private:
    LevelRules level_rules() const
    {
        return {
            .by_depth = *depth_levels,
            .depth = *level_depth == "mesh"     ? LevelRules::Depth::mesh
                     : *level_depth == "sensor" ? LevelRules::Depth::sensor
                                                : LevelRules::Depth::sensor_or_lowest,
            .depth_rule = {.theta_min_px = *theta_min_px, .theta_d_m = *theta_d_m, .printed_weight = *level_weight == "printed"},
            .angle = {.limit_deg = *angle_limit_deg, .below = *angle_rule == "below", .from_smallest = *angle_map == "smallest"},
            .scaling = *gradient_scaling == "angle"   ? GradientScaling::angle
                       : *gradient_scaling == "level" ? GradientScaling::level
                                                      : GradientScaling::none,
            .share_by_features = *level_share == "features",
            .enlarge_camera_features = *content_target == "smallest",
            .fill_with_corner = *empty_pixels == "corner"};
    }

    LoopOptions loop_options(int size) const
    {
        return {.size_px = size,
                .heights_px = *heights_px,
                .values = *values,
                .clamp_layers = *clamp == "layers",
                .init = *init,
                .levels = level_rules(),
                .style_rule = *style_sizes == "released" ? StyleRule::released : StyleRule::printed,
                .lambda_r = *lambda_r,
                .seed = static_cast<std::uint64_t>(*seed),
                .device = chosen_device(*device),
                .train_share = *train_share,
                .schedule = {.epochs = *epochs,
                             .repeats_count = *repeats_count,
                             .max_steps = *max_steps,
                             .shuffled = *order == "shuffled",
                             .rate = *rate,
                             .cosine = *decay == "cosine",
                             .decay_start = *decay_start,
                             .step_epochs = *step_epochs,
                             .step_factor = *step_factor},
                .held_out_count = *held_out_count,
                .measure_steps = *measure_steps,
                .stop_gain = *stop_gain,
                .reference = *execution == "reference",
                .checkpoint_steps = *checkpoint_steps,
                .checkpoint_seconds = *checkpoint_seconds,
                .preview_every = *preview_every};
    }
};

}  // namespace

FRESCO_STAGE("texture.optimize", TextureOptimize, "Optimizes a texture so that its views have a picture's style")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
