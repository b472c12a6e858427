#pragma once

#include "part.h"
#include "schedule.h"
#include "value_space.h"

#include <fresco/error.h>
#include <fresco/torch/optimizer_rule.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

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
    /// With `crops` false networks encode whole frames, which gives the same for more work.
    Evaluator(const std::map<std::string, std::shared_ptr<Loss>>& losses, ValueSpace space, torch::Device device,
              std::uint64_t seed, bool crops = true);

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
    /// Of the texture, of d loss / d displayed; where the texture lies.
    std::vector<SparseGradient> texture_gradients(const LevelData& level, const torch::Tensor& stored, torch::Tensor gradient,
                                                  const std::string& where);
    std::vector<SparseGradient> level_gradients(const PartPlace& place, ViewData& data, std::size_t level,
                                                const std::string& where);
    torch::Tensor weighted_sum(Part& part, const std::function<double(const LossTerm&)>& share, const std::string& where);
    /// The sum of the terms noted since the last call. Throws NotFinite for the first number that is not finite. Another device
    /// than the CPU is waited for, once.
    double settled();

    /// A number that must be finite, on the run's device.
    struct Noted
    {
        torch::Tensor value;
        std::string where;
        std::string loss;  ///< Empty: a gradient's figure instead of a term.
        std::string layer;
    };

    const std::map<std::string, std::shared_ptr<Loss>>& losses_;
    Demands demands_;
    ValueSpace space_;
    torch::Device device_;
    std::uint64_t seed_;
    bool crops_;
    std::map<std::string, double> summands_;
    std::vector<Noted> noted_;
};

}  // namespace fresco::optimize
