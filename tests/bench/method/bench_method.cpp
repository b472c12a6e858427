// A whole step of the optimization: as texture.optimize runs it, and as the released code does (whole frames, the camera picture
// encoded in every step, every texel updated), with the same loss.
#include "evaluation.h"
#include "real_components.h"
#include "uv_map_samples.h"

#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/tensor.h>
#include <fresco/torch/tensor_memory.h>
#include <fresco/uv_maps.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <limits>
#include <malloc.h>
#include <set>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace bench
{
namespace
{

using namespace fresco::optimize;

// Parts of a step: the built plugins, VGG-19 with random weights, and a generated view.

constexpr double camera_height_m = 1.4;
constexpr double wall_distance_m = 3;
constexpr double field_of_view = 1.2;  ///< Vertical field of view: twice the tangent of half the angle.
constexpr double texture_m = 12;       ///< One unit of uv.

/// A view of a wall and of the floor before it, made from formulas: uv and depth as a camera in a room sees them. The wall's
/// lower edge and the floor's far edge are apart in the texture, and the outermost column of pixels is not valid. About a tenth
/// of the texture is seen.
fresco::UvMap generated_view(int width, int height_px)
{
    fresco::UvMap map{fresco::RasterF(width, height_px, 2), fresco::RasterF(width, height_px), fresco::RasterF(width, height_px),
                      fresco::Raster8(width, height_px)};
    for (int y = 0; y < height_px; ++y)
        for (int x = 1; x + 1 < width; ++x)
        {
            const double right = (x + 0.5 - width / 2.0) / height_px * field_of_view;
            const double down = ((y + 0.5) / height_px - 0.5) * field_of_view;
            const double to_floor = down > 0 ? camera_height_m / down : 1e9;
            const bool floor = to_floor < wall_distance_m;
            const double depth = floor ? to_floor : wall_distance_m;
            const double across = right * depth / texture_m;
            map.uv.at(x, y, 0) = static_cast<float>((floor ? 0.3 : 0.7) + across);
            map.uv.at(x, y, 1) = static_cast<float>(floor ? depth / texture_m : 0.6 - down * depth / texture_m);
            map.depth.at(x, y) = static_cast<float>(depth);
            const double slant = std::sqrt(1 + right * right + down * down);
            map.cosine.at(x, y) = static_cast<float>((floor ? down : 1) / slant);
            map.valid.at(x, y) = 1;
        }
    return map;
}

/// An RGB picture, the same each time.
torch::Tensor generated_picture(int width, int height)
{
    at::manual_seed(2);
    return at::rand({3, height, width});
}

/// Prepares the network and then the losses, for generated pictures.
void prepare(fresco::FeatureNetwork& network, const std::map<std::string, std::shared_ptr<fresco::Loss>>& losses, int height_px,
             const torch::Device& device)
{
    static fresco::Progress progress;  // Losses may keep it for as long as they live.
    fresco::PrepareContext context;
    context.style.fine = generated_picture(256, 256).to(device);
    context.style.coarse = generated_picture(512, 512).to(device);
    context.camera_samples = {generated_picture(height_px * 4 / 3, height_px).to(device)};
    context.progress = &progress;
    network.prepare(context);
    for (const auto& [name, loss] : losses)
        loss->prepare(context);
}

// The steps.

struct Settings
{
    int size_px = 4096;
    int threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
    std::string device = "cpu";
    std::string precision = "full";
};

constexpr double repeats = 10;  ///< Consecutive steps on a view, as in the paper: the first one encodes the camera picture.
constexpr double lambda_r = 5000;
constexpr std::array heights{256, 432, 608, 784};

/// Makes the network encode whole frames, as the released code does, where the losses would let it encode crops.
class WholeFrames final : public fresco::Loss
{
  public:
    explicit WholeFrames(fresco::FeatureNetwork& network) : network_(network) {}
    fresco::LossNeeds needs() const override { return {.features = {{.network = &network_, .names = {}, .whole = true}}}; }
    void prepare(const fresco::PrepareContext&) override {}
    std::vector<fresco::LossTerm> evaluate(fresco::Part&) override { return {}; }

  private:
    fresco::FeatureNetwork& network_;
};

/// Distances in meters from the picture's lower to its upper border, as far as depth levels are concerned.
struct Room
{
    const char* levels;
    double nearest;
    double farthest;
};

constexpr std::array rooms{Room{"1", 0.8, 1.9}, Room{"2", 2.1, 3.3}, Room{"4", 1.2, 6.0}};

/// All that a run has before its first step on one view.
struct Studio
{
    torch::Device device = torch::kCPU;
    fresco::testing::TestFactory factory;
    std::map<std::string, std::shared_ptr<fresco::Loss>> losses;
    std::shared_ptr<fresco::TextureRepresentation> texture;
    std::shared_ptr<fresco::OptimizerRule> rule;
    ViewData view;

    Studio(const Room& room, bool reference, const Settings& settings, const std::filesystem::path& weights)
    {
        at::set_num_threads(settings.threads);
        device = torch::Device(settings.device);
        if (device.is_cuda() && !at::hasCUDA())
            throw fresco::Error("--device cuda: this libtorch finds no CUDA device");
        using Map = fresco::Value::Map;
        const auto network = made<fresco::FeatureNetwork>("features.vgg19",
                                                          Map{{"weights", weights.string()},
                                                              {"convolutions", reference ? "libtorch" : "auto"},
                                                              {"precision", reference ? "full" : settings.precision}},
                                                          factory);
        factory.add("features.vgg19", [=] { return network; });
        losses["style"] = made<fresco::Loss>("loss.gram",
                                             Map{{"weight", 1e-4},
                                                 {"targets", "both"},
                                                 {"layers", "relu1_1, relu2_1, relu3_1, relu4_1, relu5_1"},
                                                 {"layer_weights", fresco::Value::List{1000.0, 1000.0, 10.0, 10.0, 1000.0}},
                                                 {"features", Map{{"type", "features.vgg19"}}}},
                                             factory);
        losses["content"] = made<fresco::Loss>(
            "loss.content", Map{{"weight", 70.0}, {"layers", "relu4_2"}, {"features", Map{{"type", "features.vgg19"}}}}, factory);
        if (reference)
            losses["whole frames"] = std::make_shared<WholeFrames>(*network);
        prepare(*network, losses, heights.front(), device);
        texture = made<fresco::TextureRepresentation>("texture.laplacian", Map{}, factory);
        texture->allocate(settings.size_px);
        texture->move_to(device);
        // As the preset has it.
        rule = made<fresco::OptimizerRule>("optimizer.adam", Map{{"mode", "dense"}}, factory);
        rule->attach(texture->parameters());
        load_levels(room);
        move_to(view, device, !device.is_cpu());
    }

    void load_levels(const Room& room)
    {
        const fresco::testing::TemporaryFolder folder;
        fresco::Frames frames;
        frames.frames = {fresco::testing::frame("generated", fresco::testing::camera(1024, 768, 768 / field_of_view))};
        fresco::testing::set_color_picture(frames.frames[0], folder.path(), fresco::testing::noise_picture(1024, 768, 2));
        const auto maps = written_uv_maps(folder.path(), frames, {heights.begin(), heights.end()},
                                          [&](std::size_t, int width, int height)
                                          {
                                              fresco::UvMap map = generated_view(width, height);
                                              // The smallest map's depth decides on the levels.
                                              for (int y = 0; y < height && height == heights.front(); ++y)
                                                  for (int x = 0; x < width; ++x)
                                                      map.depth.at(x, y) = static_cast<float>(
                                                          room.farthest - (room.farthest - room.nearest) * y / height);
                                              return map;
                                          });
        const LevelRules rules{.by_depth = true, .angle_limit_deg = 30};
        view = std::move(*load_view(ViewSource(*maps, frames, nullptr, {}), 0, *texture, rules));
    }

    /// Waits for the losses of the step before, as texture.optimize does on a graphics card.
    void step(Evaluator& evaluator)
    {
        auto& parameters = texture->parameters();
        rule->step(
            parameters, [&] { return evaluator.evaluate(0, {}, view, "generated", parameters.size(), true); }, 1, lambda_r);
        while (evaluator.pending() > 1)
            evaluator.figures();
    }

    /// Waits for the device and gives the last step's loss.
    double ended(Evaluator& evaluator)
    {
        const double loss = evaluator.figures().loss;
        texture->parameters().front().values.flatten()[0].item();
        return loss;
    }
};

/// As the host has it for its stages.
void keep_freed_memory()
{
#if defined(__GLIBC__)
    ::mallopt(M_MMAP_THRESHOLD, 1 << 30);
    ::mallopt(M_TRIM_THRESHOLD, INT_MAX);
#endif
}

/// Figures of a step; the processor time is that of all threads together.
struct Figures
{
    double seconds = std::numeric_limits<double>::infinity();
    double processor_seconds = std::numeric_limits<double>::infinity();
    double process_mb = 0;  ///< Peak size of the process.
    double loss = 0;        ///< Loss of the first step.
};

/// The smallest times of some calls.
Figures fastest(int calls, const std::function<void()>& work)
{
    const auto now = [](clockid_t clock)
    {
        timespec time{};
        clock_gettime(clock, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    };
    Figures best;
    for (int i = 0; i < calls; ++i)
    {
        const double begin = now(CLOCK_MONOTONIC);
        const double processor = now(CLOCK_PROCESS_CPUTIME_ID);
        work();
        best.seconds = std::min(best.seconds, now(CLOCK_MONOTONIC) - begin);
        best.processor_seconds = std::min(best.processor_seconds, now(CLOCK_PROCESS_CPUTIME_ID) - processor);
    }
    return best;
}

/// Forgets the features of the camera picture.
void forget_camera(ViewData& data)
{
    for (auto& level : data.levels)
    {
        level.camera_features.clear();
        if (level.smallest)
            level.smallest->features.clear();
    }
    for (auto& [network, sheet] : data.sheets)
        sheet.camera.clear();
    data.kept.clear();
}

Figures measured(const Room& room, bool reference, const Settings& settings, const std::filesystem::path& weights)
{
    if (!reference)
    {
        keep_freed_memory();
        fresco::reuse_tensor_memory();
    }
    // As texture.optimize has it; the authors' PyTorch rounded the factors of convolutions.
    at::globalContext().setAllowTF32CuDNN(reference && settings.precision != "full");
    at::globalContext().setAllowTF32CuBLAS(false);
    Studio studio(room, reference, settings, weights);
    Evaluator evaluator(studio.losses, ValueSpace(Values::network), studio.device, 0);
    // The first step of a run sorts the filters and touches memory for the first time, either way.
    studio.step(evaluator);
    const double loss = studio.ended(evaluator);
    const auto steps = [&](int count, bool forget)
    {
        for (int i = 0; i < count; ++i)
        {
            if (forget)
                forget_camera(studio.view);
            studio.step(evaluator);
        }
        studio.ended(evaluator);
    };
    const Figures first = fastest(1, [&] { steps(1, true); });
    // A graphics card makes a step while the next one is sent.
    const int count = studio.device.is_cpu() ? 1 : 9;
    const Figures again = fastest(2, [&] { steps(count, reference); });
    const auto mean = [&](double one, double more)
    { return reference ? more / count : (one + (repeats - 1) * more / count) / repeats; };
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return {.seconds = mean(first.seconds, again.seconds),
            .processor_seconds = mean(first.processor_seconds, again.processor_seconds),
            .process_mb = static_cast<double>(usage.ru_maxrss) * 1024 / 1e6,
            .loss = loss};
}

/// In a process of its own, so that the memory of one case does not count for the next. This one must have no other threads.
Figures measured_alone(const Room& room, bool reference, const Settings& settings, const std::filesystem::path& weights)
{
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0)
        throw fresco::Error("no pipe for a case");
    const auto child = ::fork();
    if (child == 0)
        try
        {
            const Figures figures = measured(room, reference, settings, weights);
            ::_exit(::write(ends[1], &figures, sizeof figures) == sizeof figures ? 0 : 1);
        }
        catch (const std::exception& error)
        {
            std::fprintf(stderr, "error: %s\n", error.what());
            ::_exit(1);
        }
    ::close(ends[1]);
    Figures figures;
    const bool whole = ::read(ends[0], &figures, sizeof figures) == sizeof figures;
    ::close(ends[0]);
    ::waitpid(child, nullptr, 0);
    if (!whole)
        throw fresco::Error("a case ended without figures");
    return figures;
}

void print_steps(const Settings& settings)
{
    const fresco::testing::TemporaryFolder folder;
    const auto weights = random_vgg19(folder.path(), 5);
    std::printf(
        "steps: a step of the paper's method at %d², heights 256 to 784 px, %d threads: as texture.optimize runs it (10 steps a "
        "view), and as the released code does; device %s, precision %s\n"
        "  levels  way                s/step  cpu s/step  x faster (%s)  peak MB  x smaller  loss apart\n",
        settings.size_px, settings.threads, settings.device.c_str(), settings.precision.c_str(), settings.device.c_str());
    const bool by_clock = settings.device != "cpu";
    for (const auto& room : rooms)
    {
        const Figures reference = measured_alone(room, true, settings, weights);
        const Figures own = measured_alone(room, false, settings, weights);
        for (const auto& [way, of] : {std::pair{"reference", &reference}, {"texture.optimize", &own}})
        {
            const double times = by_clock ? reference.seconds / of->seconds : reference.processor_seconds / of->processor_seconds;
            std::printf("  %-6s  %-16s %8.3f %11.3f %15.1f %8.0f %10.1f %11.7f\n", room.levels, way, of->seconds,
                        of->processor_seconds, times, of->process_mb, reference.process_mb / of->process_mb,
                        std::abs(of->loss / reference.loss - 1));
            std::fflush(stdout);
        }
    }
}

/// libgomp reads its settings when it is loaded. Left alone its threads spin while they wait, which would count as work: a third
/// of a step's processor time, the reference's too.
void begin_again_without_spinning(char** argv)
{
    if (std::getenv("GOMP_SPINCOUNT") != nullptr)
        return;
    ::setenv("GOMP_SPINCOUNT", "1000", 1);  // As the host has it for its stages.
    ::execv("/proc/self/exe", argv);
}

}  // namespace
}  // namespace bench

int main(int argc, char** argv)
{
    bench::begin_again_without_spinning(argv);
    CLI::App app{"Times a step of the optimization on a generated view"};
    bench::Settings settings;
    app.add_option("--size-px", settings.size_px, "Texture size, a multiple of 8")
        ->check(CLI::Range(64, 16384))
        ->capture_default_str();
    app.add_option("--device", settings.device, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
    app.add_option("--precision", settings.precision, "Of the convolutions, as features.vgg19 has it")->capture_default_str();
    app.add_option("--threads", settings.threads, "Threads")->check(CLI::Range(1, 1024))->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try
    {
        bench::print_steps(settings);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
}
