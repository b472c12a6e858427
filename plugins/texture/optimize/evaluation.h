#pragma once

/// \file What the losses say of rendered views: for a step with the gradient of the texture (Evaluator), for held-out views
/// without one (held_out_loss), and how style and content balance. For loop.cpp.

#include "gradients.h"
#include "pictures.h"
#include "rendered_part.h"
#include "schedule.h"
#include "views.h"

#include <fresco/error.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>

#include <c10/core/Event.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fresco::optimize
{

/// A loss or a gradient is not finite; the text names step, view and loss.
class NotFinite : public Error
{
  public:
    NotFinite(std::int64_t of_step, const std::string& text) : Error(text), step(of_step) {}
    std::int64_t step;  ///< Held-out views have one beyond all steps.
};

/// The loss of a step and each loss's share of it.
struct StepFigures
{
    std::int64_t step = 0;
    double loss = 0;
    std::map<std::string, double> summands;
};

/// Renders every level of a view, lets every loss see it, and back-propagates to the texture. Used by one thread; references the
/// losses.
class Evaluator
{
  public:
    Evaluator(const std::map<std::string, std::shared_ptr<Loss>>& losses, ValueSpace space, torch::Device device,
              std::uint64_t seed);

    /// The loss of `step` on `data` and its gradients, `parameters` of them. Throws NotFinite naming the step, `view_name` and
    /// the loss. `later`: the loss is NaN, and the device is not waited for; figures() gives it, or throws, afterwards.
    Evaluation evaluate(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name,
                        std::size_t parameters, bool later = false);

    /// Evaluations whose figures are on their way.
    std::size_t pending() const { return sent_.size(); }
    /// Waits for the first of them and gives its figures.
    StepFigures figures();
    void forget_pending() { sent_.clear(); }

    /// Only the loss.
    double loss(const ScheduledStep& scheduled, ViewData& data, const std::string& view_name);

    /// Each loss's share of the sum, in the last evaluation whose loss is known.
    const std::map<std::string, double>& summands() const { return summands_; }

  private:
    /// Terms that have a gradient, and the factor of each in the sum: the loss's weight times ŵ_l.
    struct Terms
    {
        std::vector<torch::Tensor> values;
        std::vector<double> numbers;
        std::vector<torch::Tensor> factors;  ///< The numbers, on the run's device.
    };
    /// Calls work(view's picture, box, terms_of, text that names the place) for every level, one after the other, or on another
    /// device than the CPU once for all levels together. terms_of gives the terms of what the box shows.
    template <class Work>
    void each_part(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name,
                   DisplayedValues& shown, const Work& work);
    /// Adds terms of a loss to `terms`, and notes them.
    template <class Factor>
    void add_terms(const std::vector<LossTerm>& of_loss, const std::string& name, const Factor& factor, const std::string& where,
                   Terms& terms);
    /// The terms of the levels from one number to another, which lie in `picture`.
    Terms terms_of(const torch::Tensor& picture, std::int64_t step, const ScheduledStep& scheduled, ViewData& data,
                   std::pair<std::size_t, std::size_t> levels, const std::string& where);
    void set_factors(Terms& terms);

    /// A number that must be finite, on the run's device.
    struct Noted
    {
        torch::Tensor value;
        double factor;
        std::string where;
        std::string loss;  ///< Empty: a gradient's figure instead of a term.
        std::string layer;
    };
    /// Noted numbers on their way to the CPU.
    struct Sent
    {
        std::int64_t step = 0;
        std::vector<Noted> noted;
        torch::Tensor values;
        std::optional<c10::Event> arrived;  ///< Missing on the CPU.
    };
    Sent sent(std::int64_t step);
    /// Throws NotFinite for the first number that is not finite. Waits for another device than the CPU.
    static StepFigures settled(Sent sent);

    const std::map<std::string, std::shared_ptr<Loss>>& losses_;
    Demands demands_;
    ValueSpace space_;
    torch::Device device_;
    std::uint64_t seed_;
    std::map<std::string, double> summands_;
    std::vector<Noted> noted_;
    std::deque<Sent> sent_;
    std::vector<double> last_factors_;  ///< They are the same in most steps: `factors_` on the device.
    std::vector<torch::Tensor> factors_;
};

/// Reports style over content of the first step as `initial_style_over_content`: the summands (by the losses' names) of losses
/// that compare features only with the style picture, over those of losses that compare them with the camera's. Does nothing
/// where either is missing or zero. Warns where a run that begins without a picture is outside of 0.3 to 8: 1.5 is what the
/// weights of StyleMesh's losses are balanced for, other pictures and layers considered. Where a run begins with a picture,
/// content or style begins small, and the ratio says nothing of the scale.
void report_balance(const std::map<std::string, std::shared_ptr<Loss>>& losses, const std::map<std::string, double>& summands,
                    bool begins_empty, RunContext& run);

/// Splits the views, in recorded order, into those to optimize for and `count` evenly spread ones to measure on. Throws Error
/// where that leaves none to optimize for.
struct ViewSplit
{
    std::vector<std::size_t> trained;
    std::vector<std::size_t> held_out;
};
ViewSplit split_views(const std::vector<std::size_t>& views, int count);

/// A loss measured on the held-out views after some steps.
struct HeldOutLoss
{
    std::int64_t step = 0;
    double loss = 0;
    std::vector<double> parts;  ///< One for each loss, in the order of their names; their sum is `loss`.
    /// Since the stage began, without the measuring; not known of measurements before an interruption, and in no checkpoint.
    std::optional<double> seconds{};
};

/// Whether the last three measurements are worth nothing: their smallest is not below (1 - gain) times the smallest before.
bool has_stopped_falling(const std::vector<HeldOutLoss>& history, double gain);

/// Mean of the losses, without the texture's regularizer, over `views` that are not optimized for. `load`
/// gets a view ready; one is in memory at a time. Every view is measured with the losses' present state and with the draws of
/// step 0, so that measurements differ only by the texture; the state is left as it was. Throws Canceled between two views.
HeldOutLoss held_out_loss(Evaluator& evaluator, std::int64_t step, const ViewSource& source,
                          const std::vector<std::size_t>& views,
                          const std::function<std::unique_ptr<ViewData>(std::size_t)>& load,
                          const std::map<std::string, std::shared_ptr<Loss>>& losses, const Progress& progress);

}  // namespace fresco::optimize
