#include "loop.h"

#include "checkpoint.h"
#include "evaluation.h"
#include "gradients.h"
#include "rendered_part.h"
#include "schedule.h"
#include "views.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/numerics/greedy_cover.h>
#include <fresco/parallel.h>
#include <fresco/torch/tensor.h>
#include <fresco/torch/tensor_memory.h>

#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <future>
#include <optional>
#include <set>

namespace fresco::optimize
{
namespace
{

/// Progress for losses: it cancels them only before the first step, as none of them could resume a step halfway. A run is
/// canceled between two steps.
class WholeSteps final : public Progress
{
  public:
    /// `run` must outlive it.
    explicit WholeSteps(const Progress& run) : run_(run) {}

    void begin() { is_begun_ = true; }
    void check_canceled() const override
    {
        if (!is_begun_)
            run_.check_canceled();
    }
    int threads() const override { return run_.threads(); }

  private:
    const Progress& run_;
    std::atomic<bool> is_begun_{false};
};

/// A few camera pictures of `views`, spread over them, at the smallest height: RGB in [0,1], 3 x H x W.
std::vector<torch::Tensor> camera_samples(const ViewSource& source, const std::vector<std::size_t>& views,
                                          const torch::Device& device)
{
    constexpr std::size_t most = 8;
    std::vector<torch::Tensor> samples;
    for (const std::size_t i : numerics::evenly_spread(std::min(most, views.size()), views.size()))
    {
        const Raster8 picture = source.camera(views[i]);
        const int height = source.height_px(0);
        const int width = Intrinsics{picture.width, picture.height, 1, 1, 0, 0}.width_at(height);
        samples.push_back(to_tensor(resized(picture, width, height)).to(device));
    }
    return samples;
}

/// Prepares every feature network that a loss needs, once, and then every loss, in the order of their names.
void prepare(const std::map<std::string, std::shared_ptr<Loss>>& losses, const PrepareContext& context)
{
    std::set<const FeatureNetwork*> prepared;
    for (const auto& [name, loss] : losses)
        for (const auto& layers : loss->needs().features)
            if (layers.network != nullptr && prepared.insert(layers.network).second)
                layers.network->prepare(context);
    for (const auto& [name, loss] : losses)
        loss->prepare(context);
}

constexpr int largest_side = 1024;

/// `rows` of the texture from row `first` on, at size x size points.
UvMap strip(int size, int first, int rows)
{
    UvMap map{RasterF(size, rows, 2), RasterF(size, rows), RasterF(size, rows), Raster8(size, rows, 1, 1)};
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < size; ++x)
        {
            map.uv.at(x, y, 0) = (static_cast<float>(x) + 0.5F) / static_cast<float>(size);
            map.uv.at(x, y, 1) = 1 - (static_cast<float>(first + y) + 0.5F) / static_cast<float>(size);
        }
    return map;
}

/// The texture at `size` x `size` points, as 3 planes. In strips: a copy of the layers would take as much memory again.
torch::Tensor looked_up(const TextureRepresentation& texture, int size)
{
    constexpr int rows = 64;
    auto result = at::empty({3, size, size}, at::kFloat);
    for (int first = 0; first < size; first += rows)
    {
        const int count = std::min(rows, size - first);
        result.slice(1, first, first + count).copy_(texture.make_view(strip(size, first, count))->render());
    }
    return result;
}

/// Writes what the run looks like now into `folder`: `view.png`, the largest level of the view, and `texture.png`, the whole
/// texture (of size_px) at most 1024 px a side.
void write_preview(const std::filesystem::path& folder, const ImageIo& images, const ValueSpace& space, const ViewData& view,
                   const TextureRepresentation& texture, int size_px)
{
    const auto write = [&](const char* name, const torch::Tensor& stored, const torch::Tensor& hidden)
    { write_file(folder / name, images.encode_png(to_raster8(displayed_values(space, stored, hidden).picture))); };
    const auto& level = view.levels.back();
    write("view.png", cut(view.texture->render(), level.place).to(at::kCPU), level.all.logical_not().to(at::kCPU));
    const int size = std::min(largest_side, size_px);
    write("texture.png", looked_up(texture, size), at::zeros({size, size}, at::kBool));
}

/// The released code trains with the first 99% of the views, seeing or not.
std::vector<std::size_t> used_views(const ViewSource& source, Protocol protocol, RunContext& run)
{
    auto views = source.seeing_views();
    const auto share = static_cast<std::size_t>((is_released(protocol) ? 0.99 : 1.0) * static_cast<double>(source.view_count()));
    const std::size_t trained = std::max<std::size_t>(1, share);
    std::erase_if(views, [&](std::size_t view) { return view >= trained; });
    if (views.empty())
        throw Error(
            "no uv map has a valid pixel: the cameras do not see the mesh; check that mesh and poses share one world frame");
    if (views.size() < trained)
        run.message(fmt::format("{} of {} views see nothing of the mesh and are left out", trained - views.size(), trained));
    return views;
}

double share_of_ones(const Raster8& mask)
{
    const auto ones = std::count(mask.values.begin(), mask.values.end(), std::uint8_t{1});
    return static_cast<double>(ones) / static_cast<double>(mask.values.size());
}

/// On the CPU, where encoding a camera picture takes a third of a step that does so.
constexpr std::size_t kept_camera_bytes = std::size_t{1} << 31U;

class Loop
{
  public:
    Loop(const LoopInputs& inputs, const LoopComponents& components, const LoopOptions& options, RunContext& run)
        : components_(components), options_(options), run_(run),
          source_(inputs.maps, inputs.frames, components.images, options.heights_px, inputs.start), start_(inputs.start),
          space_(options.values, options.levels.protocol == Protocol::paper),
          split_(split_views(used_views(source_, options.levels.protocol, run), options.held_out_count)),
          schedule_(split_.trained, options.seed, options.schedule),
          end_step_(options.stop_at_step > 0 ? std::min(options.stop_at_step, schedule_.steps()) : schedule_.steps()),
          checkpoints_(run.checkpoint_folder()), evaluator_(components.losses, space_, options.device, options.seed),
          style_(style_sizes(inputs.style, options.levels.protocol, [&](const std::string& text) { run.message(text); })),
          whole_steps_(run), camera_memory_(options.device.is_cpu() ? kept_camera_bytes : 0)
    {
    }

    Texture operator()()
    {
        initial_rules().check();
        components_.texture.allocate(options_.size_px);
        // Else picture and gradient would cross between processor and device, which would wait for each other.
        texture_there_ = !options_.device.is_cpu() && components_.rule.runs_on(options_.device) &&
                         components_.texture.move_to(options_.device);
        prepare_components();
        components_.rule.attach(parameters());
        take_up();
        const auto start = std::chrono::steady_clock::now();
        first_step_ = step_;
        while (!walked())
        {
        }
        wait_for_writing();
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start - measuring_;
        report(seconds.count(), step_ - first_step_);
        // Its state is not needed when the layers are copied.
        components_.rule.attach({});
        Texture texture = components_.texture.to_texture();
        texture.values = space_.is_network() ? "network" : "display";
        texture.seen = seen_;
        run_.report("seen_share", share_of_ones(seen_));
        return texture;
    }

  private:
    InitialRules initial_rules() const { return {options_.init, options_.size_px, options_.seed, start_, source_.shows_start()}; }
    std::vector<TextureParameter>& parameters() { return components_.texture.parameters(); }

    std::unique_ptr<ViewData> loaded(std::size_t view) const
    {
        auto data = load_view(source_, view, components_.texture, options_.levels);
        move_to(*data, options_.device, texture_there_);
        return data;
    }

    void prepare_components()
    {
        PrepareContext context;
        context.style.fine = to_tensor(style_.fine).to(options_.device);
        context.style.coarse = to_tensor(style_.coarse).to(options_.device);
        context.camera_samples = camera_samples(source_, split_.trained, options_.device);
        context.seed = options_.seed;
        context.progress = &whole_steps_;
        context.message = [this](const std::string& text) { run_.message(text); };
        prepare(components_.losses, context);
        whole_steps_.begin();
        for (const auto& [name, loss] : components_.losses)
            prepared_states_.emplace(name, loss->state());
    }

    /// Puts a checkpoint back.
    void restore(const Checkpoint& checkpoint)
    {
        checkpoint.restore(parameters(), components_.rule, components_.losses);
        seen_ = checkpoint.seen;
        step_ = checkpoint.step;
        rollbacks_ = checkpoint.rollbacks;
        held_out_ = checkpoint.held_out;
    }

    /// Resumes where the last run was interrupted, or starts.
    void take_up()
    {
        const auto used = checkpoints_.use_latest(
            end_step_, [this](const Checkpoint& c) { restore(c); }, run_);
        if (used == CheckpointFolder::Used::due)
            due_step_ = step_;
        if (used != CheckpointFolder::Used::none)
            run_.message(fmt::format("going on after step {} of {}", step_, end_step_));
        else
            start_anew();
    }

    void start_anew()
    {
        step_ = 0;
        rollbacks_ = 0;
        held_out_.clear();
        components_.rule.attach(parameters());
        for (const auto& [name, loss] : components_.losses)
            loss->restore(prepared_states_.at(name));
        for (auto& parameter : parameters())
            write_zeros(parameter.values);
        auto initial = initial_texture(source_, split_.trained, style_.fine, initial_rules(), run_);
        seen_ = std::move(initial.seen);
        if (initial.picture.empty())
            return;
        space_.store(initial.picture);
        components_.texture.set_picture(initial.picture);
    }

    /// To the last step; false where a loss was not finite and the run has gone back.
    bool walked()
    {
        const auto first_visit = static_cast<std::size_t>(step_ / options_.schedule.repeats_count);
        const Demands demands = demands_of(components_.losses);
        ViewFeed feed(options_.device, first_visit, schedule_.visits(),
                      [&](std::size_t visit)
                      {
                          auto data = loaded(schedule_.view_of_visit(visit));
                          get_parts_ready(*data, demands, options_.device);
                          return data;
                      });
        ViewData* data = nullptr;
        std::optional<std::size_t> loaded_visit;
        at::set_num_threads(std::max(1, run_.threads()));
        try
        {
            for (; step_ < end_step_; ++step_)
            {
                interrupt_point();
                measure();
                if (has_stopped_falling(held_out_, options_.stop_gain))
                    return true;
                const auto scheduled = schedule_.at(step_);
                if (loaded_visit != scheduled.visit)
                {
                    if (data != nullptr)
                        camera_memory_.keep(*data);
                    data = &feed.next();
                    camera_memory_.give_back(*data);
                    loaded_visit = scheduled.visit;
                }
                checked_step(scheduled, *data);
            }
            take_figures(0);
            measure();
        }
        catch (const NotFinite& error)
        {
            evaluator_.forget_pending();
            step_ = std::min(step_, error.step);
            go_back(error);
            return false;
        }
        return true;
    }

    /// The last good state, at half the rate.
    void go_back(const NotFinite& error)
    {
        constexpr std::int64_t most = 3;
        const std::int64_t rollbacks = rollbacks_ + 1;
        if (rollbacks > most)
            throw Error(fmt::format(
                "{}; the run went back {} times and halved the rate each time, without success; its last checkpoint is kept",
                error.what(), most));
        wait_for_writing();
        run_.warning(std::string(error.what()) + "; going back to the last good state, at half the rate");
        const bool back = checkpoints_.use_before(
            step_, [this](const Checkpoint& c) { restore(c); }, run_);
        if (!back)
            start_anew();
        rollbacks_ = rollbacks;
        due_step_ = back ? step_ : -1;
    }

    /// Between two steps everything is consistent: here a run may end, and goes on later.
    void interrupt_point()
    {
        may_be_interrupted([this] { run_.check_canceled(); });
        if (options_.checkpoint_steps > 0 && step_ > 0 && step_ % options_.checkpoint_steps == 0 && step_ != due_step_)
        {
            write([this](const Checkpoint& checkpoint) { checkpoints_.write_due(checkpoint); });
            due_step_ = step_;
            kept_ = std::chrono::steady_clock::now();
        }
        else
            keep_for_a_kill();
    }

    /// SIGKILL gives no warning: writes a checkpoint every checkpoint_seconds, or after twenty times what
    /// keeping them takes.
    void keep_for_a_kill()
    {
        const auto begin = std::chrono::steady_clock::now();
        const std::chrono::duration<double> least(options_.checkpoint_seconds);
        if (options_.checkpoint_seconds <= 0 || step_ == first_step_ || step_ == kept_step_ || step_ == due_step_ ||
            begin - kept_ < std::max(least, std::chrono::duration<double>(20 * keeping_)))
            return;
        write([this](const Checkpoint& checkpoint) { checkpoints_.write_interrupted(checkpoint); });
        kept_step_ = step_;
        kept_ = std::chrono::steady_clock::now();
        keeping_ = kept_ - begin;
    }

    /// Runs a part that may be canceled; the next run then goes on from before it.
    template <class Act>
    void may_be_interrupted(Act act)
    {
        try
        {
            act();
        }
        catch (const Canceled&)
        {
            take_figures(0);
            wait_for_writing();
            if (step_ != due_step_)
                checkpoints_.write_interrupted(state());
            if (step_ > 0 && end_step_ == schedule_.steps())
                run_.message(fmt::format("stopped after step {0}; stop_at_step: {0} makes that the result", step_));
            throw;
        }
    }

    /// Writes the present state by `into`. On another device than the CPU steps are quick and writing is not: there a copy of the
    /// state is written while the run goes on.
    void write(std::function<void(const Checkpoint&)> into)
    {
        // A step whose loss is not finite must not be in it.
        take_figures(0);
        wait_for_writing();
        if (options_.device.is_cpu())
            return into(state());
        writing_ = std::async(std::launch::async, [into = std::move(into), copy = state().copied()] { into(copy); });
    }

    /// Until the last state is written. Throws what its writing threw.
    void wait_for_writing()
    {
        if (writing_.valid())
            writing_.get();
    }

    /// Refers to the tensors, copies nothing.
    Checkpoint state() const
    {
        Checkpoint result{step_, rollbacks_, {}, components_.rule.state(), {}, seen_, held_out_};
        for (const auto& parameter : components_.texture.parameters())
            result.parameters.emplace(parameter.name, parameter.values);
        for (const auto& [name, loss] : components_.losses)
            result.losses.emplace(name, loss->state());
        return result;
    }

    /// The loss on the held-out views, at the start, every so many steps, and at the end.
    void measure()
    {
        const bool due = step_ % options_.measure_steps == 0 || step_ == end_step_;
        if (split_.held_out.empty() || !due || (!held_out_.empty() && held_out_.back().step == step_))
            return;
        take_figures(0);
        const auto begin = std::chrono::steady_clock::now();
        may_be_interrupted(
            [this]
            {
                held_out_.push_back(held_out_loss(
                    evaluator_, step_, source_, split_.held_out, [this](std::size_t view) { return loaded(view); },
                    components_.losses, run_));
            });
        run_.metric("held_out_loss", held_out_.back().loss);
        const auto end = std::chrono::steady_clock::now();
        measuring_ += end - begin;
        held_out_.back().seconds = std::chrono::duration<double>(end - begun_ - measuring_).count();
    }

    /// A step whose failure does not hide that the one before was not finite, from which it may follow.
    void checked_step(const ScheduledStep& scheduled, ViewData& data)
    {
        try
        {
            one_step(scheduled, data);
        }
        catch (const NotFinite&)
        {
            throw;
        }
        catch (...)
        {
            take_figures(0);
            throw;
        }
    }

    void one_step(const ScheduledStep& scheduled, ViewData& data)
    {
        const Evaluate evaluate = [&] {
            return evaluator_.evaluate(step_, scheduled, data, source_.name(scheduled.view), parameters().size(), texture_there_);
        };
        const double loss =
            components_.rule.step(parameters(), evaluate, schedule_.rate(step_) * std::pow(0.5, rollbacks_), options_.lambda_r);
        if (texture_there_)
            take_figures(1);
        else
            report_step({step_, loss, evaluator_.summands()});
        if (!space_.is_clamped())
            for (auto& parameter : parameters())
                write_clamped(parameter.values, static_cast<float>(space_.stored_range().first),
                              static_cast<float>(space_.stored_range().second));
        run_.progress(static_cast<double>(step_ + 1), static_cast<double>(end_step_), "steps");
        if (components_.images != nullptr && !data.levels.empty())
            show(data);
    }

    /// From the first step on, and seldom enough to take a twentieth of the time.
    void show(const ViewData& data)
    {
        const auto begin = std::chrono::steady_clock::now();
        const std::chrono::duration<double> least(options_.preview_seconds);
        if (options_.preview_seconds <= 0 ||
            (shown_ && begin - *shown_ < std::max(least, std::chrono::duration<double>(20 * showing_))))
            return;
        write_preview(run_.preview_folder(), *components_.images, space_, data, components_.texture, options_.size_px);
        shown_ = std::chrono::steady_clock::now();
        showing_ = *shown_ - begin;
    }

    /// Reports steps that the device has ended, all but the last `pending` of them: with one on its way it always has work.
    void take_figures(std::size_t pending)
    {
        while (evaluator_.pending() > pending)
            report_step(evaluator_.figures());
    }

    void report_step(const StepFigures& figures)
    {
        last_summands_ = figures.summands;
        if (figures.step == 0)
            report_balance(components_.losses, last_summands_, options_.init == Init::zeros || options_.init == Init::color,
                           run_);
        run_.metric("loss", figures.loss);
    }

    void report(double seconds, std::int64_t done)
    {
        run_.report("steps", step_);
        run_.report("views", split_.trained.size());
        if (!held_out_.empty())
            report_held_out();
        if (rollbacks_ > 0)
            run_.report("rollbacks", rollbacks_);
        run_.report("seconds_per_step", done > 0 ? seconds / static_cast<double>(done) : 0.0);
        Value summands{Value::Map{}};
        for (const auto& [name, value] : last_summands_)
            summands.set(name, value);
        run_.report("losses_at_last_step", std::move(summands));
    }

    void report_held_out()
    {
        Value::List list;
        for (const HeldOutLoss& measured : held_out_)
        {
            Value entry{Value::Map{{"step", measured.step}, {"loss", measured.loss}}};
            std::size_t part = 0;
            for (const auto& [name, loss] : components_.losses)
                entry.set(name + "_loss", measured.parts.at(part++));
            if (measured.seconds)
                entry.set("seconds", *measured.seconds);
            list.push_back(std::move(entry));
        }
        run_.report("held_out_views", split_.held_out.size());
        run_.report("held_out", std::move(list));
    }

    LoopComponents components_;
    const LoopOptions& options_;
    RunContext& run_;
    ViewSource source_;
    const Texture* start_;
    ValueSpace space_;
    ViewSplit split_;
    Schedule schedule_;
    std::int64_t end_step_;
    CheckpointFolder checkpoints_;
    Evaluator evaluator_;
    StyleSizes style_;
    std::map<std::string, TensorMap> prepared_states_;  ///< States of the losses before the first step.
    Raster8 seen_;
    std::vector<HeldOutLoss> held_out_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::duration measuring_{};
    std::map<std::string, double> last_summands_;  ///< Summands of the losses in the last step.
    bool texture_there_ = false;                   ///< On the run's device, which is not the CPU.
    WholeSteps whole_steps_;
    CameraMemory camera_memory_;
    std::int64_t step_ = 0;
    std::int64_t first_step_ = 0;  ///< First step of this process.
    std::int64_t rollbacks_ = 0;
    std::chrono::steady_clock::time_point kept_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::duration keeping_{};  ///< Duration of the last time.
    std::int64_t kept_step_ = -1;
    std::int64_t due_step_ = -1;  ///< Step of the last checkpoint that was due, as far as this process knows.
    std::optional<std::chrono::steady_clock::time_point> shown_;
    std::chrono::steady_clock::duration showing_{};
    std::future<void> writing_;  ///< Writes a checkpoint on another thread; the destructor waits.
};

}  // namespace

Texture optimized_texture(const LoopInputs& inputs, const LoopComponents& components, const LoopOptions& options, RunContext& run)
{
    reuse_tensor_memory();
    Loop loop(inputs, components, options, run);
    return loop();
}

}  // namespace fresco::optimize
