#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/tensor.h>

#include <ATen/Parallel.h>
#include <ATen/ops/full.h>
#include <ATen/ops/zeros_like.h>
#include <torch/optim/lbfgs.h>

#include <cstdint>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>
#include <vector>

#include <dlfcn.h>

namespace
{

/// While there is one, libtorch's sums, and those of the BLAS behind it, are one thread's: their order depends on the number of
/// threads.
class OneThread
{
  public:
    OneThread() : before_(at::get_num_threads())
    {
        at::set_num_threads(1);
        // OpenBLAS may have threads of its own. Nothing else in this process multiplies by it.
        if (void* set = ::dlsym(RTLD_DEFAULT, "openblas_set_num_threads"); set != nullptr)
            reinterpret_cast<void (*)(int)>(set)(1);
    }
    ~OneThread() { at::set_num_threads(before_); }
    OneThread(const OneThread&) = delete;
    OneThread& operator=(const OneThread&) = delete;

    int before() const { return before_; }

  private:
    int before_;
};

class OptimizerLbfgs final : public fresco::OptimizerRule
{
    fresco::Option<int> iterations_count{this, "iterations_count", 4, fresco::range(1, 100),
                                         "Iterations of L-BFGS per step, on one view; each needs one or more evaluations"};
    /// In learning rates: a line search may otherwise throw hardly seen texels far out.
    static constexpr double max_change = 10;
    /// Beyond this the dense vectors are the wrong way to do it.
    static constexpr int max_memory_mb = 4096;

  public:
    void attach(const std::vector<fresco::TextureParameter>& parameters) override
    {
        std::int64_t values = 0;
        for (const auto& parameter : parameters)
            values += parameter.values.numel();
        // Two vectors for each iteration, and what libtorch's step and its line search copy.
        const double megabytes = 4e-6 * static_cast<double>(values) * (2 * *iterations_count + 12);
        if (megabytes > max_memory_mb)
            throw fresco::Error(
                fmt::format("optimizer.lbfgs would need {:.0f} MB for {} values and `iterations_count` {}, more than {}: use "
                            "optimizer.adam, a smaller texture or fewer iterations",
                            megabytes, values, *iterations_count, max_memory_mb));
    }

    double step(std::vector<fresco::TextureParameter>& parameters, const fresco::Evaluate& evaluate, double rate,
                double lambda_r) override
    {
        std::vector<torch::Tensor> values;
        std::vector<torch::Tensor> before;
        for (const auto& parameter : parameters)
        {
            values.push_back(parameter.values);
            before.push_back(parameter.values.clone());
        }
        std::optional<double> first_loss;
        const OneThread one_thread;
        const auto closure = [&]
        {
            at::set_num_threads(one_thread.before());
            const auto evaluation = evaluate();
            at::set_num_threads(1);
            if (!first_loss)
                first_loss = evaluation.loss;
            return at::full({}, evaluation.loss + set_gradients(parameters, evaluation.gradients, lambda_r), at::kDouble);
        };
        // Its history is of this step only: differences between gradients of two views would describe neither.
        torch::optim::LBFGS(values, torch::optim::LBFGSOptions(rate)
                                        .max_iter(*iterations_count)
                                        .history_size(*iterations_count)
                                        .tolerance_grad(0)
                                        .tolerance_change(0)
                                        .line_search_fn("strong_wolfe"))
            .step(closure);
        const double most = rate * max_change;
        for (std::size_t i = 0; i < values.size(); ++i)
        {
            values[i].copy_(before[i] + (values[i] - before[i]).clamp(-most, most));
            values[i].mutable_grad().reset();
        }
        return first_loss.value();
    }

    fresco::TensorMap state() const override { return {}; }
    void restore(const fresco::TensorMap&) override {}

  private:
    /// The sparse gradients and the regularizer's as those of the parameters; returns the regularizer.
    static double set_gradients(std::vector<fresco::TextureParameter>& parameters,
                                const std::vector<fresco::SparseGradient>& sparse, double lambda_r)
    {
        double penalty = 0;
        for (std::size_t i = 0; i < parameters.size(); ++i)
        {
            auto& values = parameters[i].values;
            auto gradient = at::zeros_like(values);
            gradient.index_copy_(0, sparse.at(i).texels, sparse[i].values);
            // λ_r k mean(values²) and its derivative.
            if (const double factor = lambda_r * parameters[i].regularizer; factor > 0)
            {
                penalty += factor * fresco::ordered_mean(values * values).item<double>();
                gradient.add_(values, 2 * factor / static_cast<double>(values.numel()));
            }
            values.mutable_grad() = gradient;
        }
        return penalty;
    }
};

}  // namespace

FRESCO_COMPONENT("optimizer.lbfgs", OptimizerLbfgs, fresco::OptimizerRule,
                 "libtorch's L-BFGS on one view after another: few, expensive steps, for small textures")
