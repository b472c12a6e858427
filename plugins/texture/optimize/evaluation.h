#pragma once

/// \file What the losses say of rendered views: for a step with the gradient of the texture (Evaluator), for held-out views
/// without one (held_out_loss), and how style and content balance. For loop.cpp.

#include "pictures.h"
#include "rendered_part.h"
#include "schedule.h"
#include "views.h"

#include <fresco/error.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>

#include <cstdint>
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
    using Error::Error;
};

/// Renders every level of a view, lets every loss see it, and back-propagates to the texture. Used by one thread; references the
/// losses.
class Evaluator
{
  public:
    Evaluator(const std::map<std::string, std::shared_ptr<Loss>>& losses, ValueSpace space, torch::Device device,
              std::uint64_t seed);

    /// The loss of `step` on `data` and its gradients, `parameters` of them. Throws NotFinite naming the step, `view_name` and
    /// the loss.
    Evaluation evaluate(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name,
                        std::size_t parameters);

    /// Only the loss.
    double loss(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name);

    /// Each loss's share of the last evaluation's sum.
    const std::map<std::string, double>& summands() const { return summands_; }

  private:
    /// Calls work(place, level, text that names the place) for every level of the view.
    template <class Work>
    void each_level(std::int64_t step, const ScheduledStep& scheduled, const ViewData& data, const std::string& view_name,
                    const Work& work);
    /// The level as it is displayed, 3 x H x W, on the run's device; `stored`: the same in the texture's values.
    torch::Tensor displayed(LevelData& level, torch::Tensor& stored) const;
    /// Gradients of the texture from d loss / d displayed, on the texture's device.
    std::vector<SparseGradient> texture_gradients(const LevelData& level, const torch::Tensor& stored, torch::Tensor gradient,
                                                  const std::string& where);
    std::vector<SparseGradient> level_gradients(const PartPlace& place, ViewData& data, std::size_t level,
                                                const std::string& where);
    /// Terms that have a gradient, and the factor of each in the sum: the loss's weight times ŵ_l.
    struct Terms
    {
        std::vector<torch::Tensor> values;
        std::vector<torch::Tensor> factors;
    };
    /// Evaluates the losses of a part and adds them to the noted terms.
    Terms terms_of(Part& part, const std::function<double(const LossTerm&)>& share, const std::string& where);
    /// The sum of the terms noted since the last call. Throws NotFinite for the first number that is not finite. Another device
    /// than the CPU is waited for, once.
    double settled();

    /// A number that must be finite, on the run's device.
    struct Noted
    {
        torch::Tensor value;
        double factor;
        std::string where;
        std::string loss;  ///< Empty: a gradient's figure instead of a term.
        std::string layer;
    };

    const std::map<std::string, std::shared_ptr<Loss>>& losses_;
    Demands demands_;
    ValueSpace space_;
    torch::Device device_;
    std::uint64_t seed_;
    std::map<std::string, double> summands_;
    std::vector<Noted> noted_;
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
