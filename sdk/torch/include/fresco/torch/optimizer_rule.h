#pragma once

#include <fresco/torch/loss.h>
#include <fresco/torch/texture_representation.h>

#include <functional>
#include <vector>

namespace fresco
{

/// The loss at the parameters' current values and its gradients, one per parameter (without the regularizer).
struct Evaluation
{
    double loss = 0;  ///< NaN where the parameters are not on the CPU: no step waits for another device.
    std::vector<SparseGradient> gradients;
};

/// Renders, evaluates and back-propagates the step's view. A rule calls it at least once; a line search calls it several times.
using Evaluate = std::function<Evaluation()>;

/// How a step changes the texture. Used by one thread.
class OptimizerRule : public Component
{
  public:
    static constexpr std::string_view component_kind = "optimizer";
    ~OptimizerRule() override;

    /// Whether parameters and gradients may lie on `device`; the default supports only the CPU. A rule that needs
    /// Evaluation::loss must not run on a device.
    virtual bool runs_on(const torch::Device& device) const;
    /// Before the first step, and where a run starts over: makes its state for these parameters. After
    /// the last step it is called without any.
    virtual void attach(const std::vector<TextureParameter>& parameters) = 0;
    /// One step at learning rate `rate` in the unit of the stored values. Others may set values before the first step after
    /// attach() or restore(), and from then on change none that is zero. The rule adds λ_r k_i mean(values²) itself, so that a
    /// rule for visible texels need touch no others. Returns the loss of the first evaluation.
    virtual double step(std::vector<TextureParameter>& parameters, const Evaluate& evaluate, double rate, double lambda_r) = 0;
    /// Everything that step remembers; restore(state()) goes on with the same bytes.
    virtual TensorMap state() const = 0;
    virtual void restore(const TensorMap& state) = 0;
};

}  // namespace fresco
