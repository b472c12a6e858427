#include "default_losses.h"
#include "loop.h"

#include <fresco/stage.h>

#include <ATen/Context.h>
#include <torch/version.h>

#include <string>

namespace
{

/// `auto` takes a CUDA device where libtorch finds one.
torch::Device chosen_device(const std::string& wanted)
{
    if (wanted == "cuda" && !at::hasCUDA())
        throw fresco::Error("option \"device\": cuda is not available: this libtorch (" TORCH_VERSION
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

class TextureOptimize final : public fresco::Stage
{
    fresco::Input<fresco::UvMaps> uvmaps{this, "uvmaps", "Which texel each pixel of each view sees"};
    fresco::Input<fresco::Frames> frames{this, "frames", "The frames that the uv maps were made for, with their color pictures"};
    fresco::Input<fresco::Image> style{this, "style", "Style picture"};
    fresco::Input<fresco::Texture> start{
        this, "start", fresco::optional,
        "With init: frames, the texture to recolor and start from; not wired: colors of the pictures"};
    fresco::Output<fresco::Texture> texture{this, "texture", "The optimized texture, layer by layer"};

    fresco::Option<int> size_px{this, "size_px", 0, fresco::range(0, 16384),
                                "Texels per side, a multiple of 8 for the default texture; 0: as the uv maps say, which have it "
                                "from the atlas"};
    fresco::Option<std::vector<int>> heights_px{this, "heights_px", std::vector<int>{}, fresco::at_least(1),
                                                "Heights of the uv maps to render, each a level; empty: all"};
    fresco::Option<int> epochs{this, "epochs", 2, fresco::range(1, 100000), "Number of visits to every view"};
    fresco::Option<int> repeats_count{this, "repeats_count", 8, fresco::range(1, 100000),
                                      "Consecutive steps on a view at each visit"};
    fresco::Option<std::int64_t> max_steps{this, "max_steps", 0, fresco::at_least(0), "Maximum number of steps; 0: no limit"};
    fresco::Option<std::string> order{this, "order", "shuffled", fresco::one_of({"shuffled", "recorded"}),
                                      "Order of the views in an epoch; shuffled: seeded, and evenly spread over the recording"};
    fresco::Option<double> rate{this, "rate", 0.02, fresco::range(0, 1e6), "Learning rate, in units of `values`"};
    fresco::Option<std::string> decay{
        this, "decay", "cosine", fresco::one_of({"cosine", "step"}),
        "cosine: full rate for decay_start, then down to 0; step: multiplied by step_factor every step_epochs"};
    fresco::Option<double> decay_start{this, "decay_start", 0.5, fresco::range(0, 1),
                                       "With decay cosine: share of the steps at the full rate"};
    fresco::Option<int> step_epochs{this, "step_epochs", 3, fresco::at_least(1), "With decay step: epochs between two drops"};
    fresco::Option<double> step_factor{this, "step_factor", 0.1, fresco::range(0, 1), "With decay step: factor of each drop"};
    fresco::Option<std::string> values{this, "values", "display", fresco::one_of({"display", "network"}),
                                       "Stored values: RGB in [0,1], or BGR in 0..255 minus the network's mean"};
    fresco::Option<std::string> clamp{
        this, "clamp", "sum", fresco::one_of({"sum", "layers"}),
        "Clamp the sum of the layers at lookup, or the stored values of each layer after every step"};
    fresco::Option<std::string> init{
        this, "init", "frames", fresco::one_of({"frames", "zeros", "color", "noise"}),
        "Start from: recolored pictures (or start), zeros, the style's mean color, or noise around it"};
    fresco::Option<double> lambda_r{this, "lambda_r", 0, fresco::at_least(0),
                                    "λ_r in the regularizer λ_r Σ k_i mean(layer_i²); the paper: 5000, in network units"};
    fresco::Option<std::string> gradient_scaling{this, "gradient_scaling", "angle", fresco::one_of({"none", "level", "angle"}),
                                                 "Multiply each pixel's gradient by the level's share in it (level), and by the "
                                                 "cosine between normal and view (angle)"};
    fresco::Option<bool> depth_levels{this, "depth_levels", false,
                                      "Show each pixel only at the heights that fit its depth, so that patterns keep one size in "
                                      "the world"};
    fresco::Option<double> theta_d_m{this, "theta_d_m", 0.25, fresco::range(0.001, 1000),
                                     "θ_d: ideal height = theta_min_px · depth / theta_d_m; smaller for short-range scans"};
    fresco::Option<double> theta_min_px{this, "theta_min_px", 32, fresco::range(1, 10000),
                                        "θ_min: height in pixels of a length θ_d seen from 1 m"};
    fresco::Option<std::string> level_weight{
        this, "level_weight", "nearest", fresco::one_of({"nearest", "printed"}),
        "Weight of the nearer of two heights: larger the nearer it is (nearest), or the paper's formula (printed)"};
    fresco::Option<std::string> level_depth{this, "level_depth", "mesh", fresco::one_of({"mesh", "sensor", "sensor_or_lowest"}),
                                            "Depth for the levels; pixels that the sensor did not measure are in no level "
                                            "(sensor) or in the lowest (sensor_or_lowest)"};
    fresco::Option<std::string> level_share{this, "level_share", "pixels", fresco::one_of({"pixels", "features"}),
                                            "Weight of a level in the sum: its number of pixels, or of cells in each layer"};
    fresco::Option<double> angle_limit_deg{this, "angle_limit_deg", 90, fresco::range(0, 90),
                                           "Largest angle between normal and view for the fine style; 90: all pixels"};
    fresco::Option<std::string> angle_rule{this, "angle_rule", "at_most", fresco::one_of({"at_most", "below"}),
                                           "Whether the limit itself passes"};
    fresco::Option<std::string> angle_map{this, "angle_map", "own", fresco::one_of({"own", "smallest"}),
                                          "Angles at each height, or at the smallest, enlarged"};
    fresco::Option<std::string> empty_pixels{
        this, "empty_pixels", "black", fresco::one_of({"black", "corner"}),
        "What pixels without a surface show to the losses' networks: black, or the texture's "
        "first texel"};
    fresco::Option<std::string> content_target{this, "content_target", "own", fresco::one_of({"own", "smallest"}),
                                               "Camera features at each height, or at the smallest, enlarged"};
    fresco::Option<std::string> style_sizes{this, "style_sizes", "printed", fresco::one_of({"printed", "released"}),
                                            "How the fine and the coarse style picture are sized"};
    fresco::Option<double> train_share{this, "train_share", 1, fresco::range(0.01, 1),
                                       "Share of the views to use, the first ones"};
    fresco::Option<int> held_out_count{this, "held_out_count", 0, fresco::range(0, 16),
                                       "Number of evenly spread views to measure the losses on instead of optimizing"};
    fresco::Option<int> measure_steps{this, "measure_steps", 50, fresco::at_least(1),
                                      "With held_out_count: steps between two measurements"};
    fresco::Option<double> stop_gain{
        this, "stop_gain", 0, fresco::range(0, 0.99),
        "With held_out_count: stop when three measurements have not lowered the loss by this share; 0: run all steps"};
    fresco::Option<std::string> execution{this, "execution", "active", fresco::one_of({"active", "reference"}),
                                          "active: encode only the parts of a frame with pixels of a level, and the camera "
                                          "picture once per visit; reference: encode everything in every step, for comparison"};
    fresco::Option<std::int64_t> seed{this, "seed", 0, fresco::at_least(0),
                                      "Seed of the views' order, of the losses' sampling and of the noise of `init: noise`"};
    fresco::Option<std::string> device{this, "device", "auto", fresco::one_of({"auto", "cpu", "cuda"}),
                                       "Where losses are computed"};
    fresco::Option<fresco::InputFile> weights{this, "weights", fresco::InputFile{},
                                              fresco::extensions({".safetensors", ".pth", ".pt"}),
                                              "VGG-19 weights for `losses: auto`; empty: losses without a network"};
    // In the key: where a run goes back to after a loss that is not finite depends on it.
    fresco::Option<int> checkpoint_steps{this, "checkpoint_steps", 200, fresco::at_least(0),
                                         "Steps between two checkpoints that a run may roll back to; 0: none"};
    fresco::Option<double> checkpoint_seconds{this,
                                              "checkpoint_seconds",
                                              30,
                                              fresco::range(0, 86400),
                                              "Maximum seconds of work lost when a run is killed, at least twenty times the cost "
                                              "of a checkpoint; 0: by checkpoint_steps",
                                              fresco::not_in_key};
    fresco::Option<int> preview_every{
        this, "preview_every", 100, fresco::at_least(0), "Steps between two preview pictures; 0: none", fresco::not_in_key};

    fresco::SlotMap<fresco::Loss> losses{this, "losses", "auto", "Losses on the rendered views"};
    fresco::Slot<fresco::TextureRepresentation> representation{this, "texture", "texture.laplacian", "How the texture is stored"};
    fresco::Slot<fresco::OptimizerRule> optimizer{this, "optimizer",
                                                  R"({"type": "optimizer.adam", "mode": "visible", "beta1": 0.9, "beta2": 0.99})",
                                                  "How a step changes the texture"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", fresco::optional,
                                         "Reads pictures that are not NPY, writes previews; none: only NPY, no previews"};

  public:
    TextureOptimize()
    {
        losses.auto_rule("weights", fresco::optimize::losses_without_weights, fresco::optimize::losses_with_weights);
    }

    void run(fresco::RunContext& run) override
    {
        if (losses->empty())
            throw fresco::Error("option \"losses\" is empty; set at least one, or remove the option");
        if (*stop_gain > 0 && *held_out_count == 0)
            throw fresco::Error("option \"stop_gain\" needs held-out views; set held_out_count too");
        constexpr const char* source = "the uv maps on port 'uvmaps'";
        const auto options = loop_options(fresco::painted_size_px(*size_px, uvmaps->texture_px, source, run));
        fresco::check_uv_bits(*uvmaps, options.size_px, source);
        run.report("device", options.device.is_cuda() ? "cuda" : "cpu");
        if (start.has_value() && !start->atlas.empty() && !uvmaps->atlas.empty() && start->atlas != uvmaps->atlas)
            throw fresco::Error(
                "the texture on port 'start' was made for another atlas than the uv maps on port 'uvmaps': wire a "
                "texture of the same atlas");
        fresco::Texture result = fresco::optimize::optimized_texture(
            {*uvmaps, *frames, style->pixels, start.has_value() ? &*start : nullptr},
            {*losses, *representation, *optimizer, images.has_value() ? images.get().get() : nullptr}, options, run);
        result.atlas = uvmaps->atlas;
        texture = std::move(result);
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 2, .per_frame = 0.03, .per_pixel = 2.5e-6},
                .parallel_share = 1,
                .memory_mb = {.fixed = 400, .per_texel = 4e-5, .per_pixel = 1.1e-3},
                .disk_mb = {.per_texel = 1.7e-5},
                .texels = {.squares_of = "size_px"},
                .pixels = {.squares_of = "heights_px"},
                .steps = {.times = {"epochs", "repeats_count"}, .at_most = "max_steps"}};
    }

  private:
    fresco::optimize::LevelRules level_rules() const
    {
        using fresco::optimize::GradientScaling;
        using fresco::optimize::LevelRules;
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

    fresco::optimize::LoopOptions loop_options(int size) const
    {
        using fresco::optimize::StyleRule;
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
