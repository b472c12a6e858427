#include "lbfgs.h"

#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/optimizer_rule.h>

#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <string>

namespace
{

namespace lb = fresco::lbfgs;

class OptimizerLbfgs final : public fresco::OptimizerRule
{
    fresco::Option<int> history_count{this, "history_count", 10, fresco::range(1, 100),
                                      "Past steps that shape the search direction"};
    fresco::Option<std::string> line_search{
        this, "line_search", "strong_wolfe", fresco::one_of({"strong_wolfe", "backtracking"}),
        "strong_wolfe: until value and slope have decreased enough; backtracking: halve the step until the value has"};
    fresco::Option<int> max_evaluations{this, "max_evaluations", 8, fresco::range(2, 100),
                                        "Maximum number of loss evaluations per step, including the first"};
    fresco::Option<double> max_change{this, "max_change", 10.0, fresco::range(1e-3, 1e9),
                                      "Largest change of a value in a step, in learning rates"};
    fresco::Option<int> max_memory_mb{this,
                                      "max_memory_mb",
                                      4096,
                                      fresco::range(1, 10'000'000),
                                      "Reject textures that would need more memory",
                                      fresco::not_in_key};

  public:
    void attach(const std::vector<fresco::TextureParameter>& parameters) override
    {
        pairs_.clear();
        size_ = 0;
        for (const auto& parameter : parameters)
            size_ += static_cast<std::size_t>(parameter.values.numel());
        const double megabytes = lb::memory_bytes(size_, static_cast<std::size_t>(*history_count)) / 1e6;
        if (megabytes > *max_memory_mb)
            throw fresco::Error(fmt::format(
                "optimizer.lbfgs would need {:.0f} MB for {} values and `history_count` {}, more than `max_memory_mb` "
                "{}: use optimizer.adam, a smaller texture or a shorter history, or raise max_memory_mb",
                megabytes, size_, *history_count, *max_memory_mb));
    }

    double step(std::vector<fresco::TextureParameter>& parameters, const fresco::Evaluate& evaluate, double rate,
                double lambda_r) override
    {
        auto x = flattened(parameters);
        if (x.size() != size_)
            throw std::logic_error("optimizer.lbfgs: step() with other parameters than attach()");
        double first_loss = 0;
        bool first = true;
        const auto function = [&](const lb::Vector& at, lb::Vector& gradient)
        {
            store(at, parameters);
            const auto evaluation = evaluate();
            if (first)
                first_loss = evaluation.loss;
            first = false;
            gradient.assign(gradient.size(), 0.0F);
            return evaluation.loss + add_gradients(parameters, evaluation.gradients, lambda_r, gradient);
        };
        lb::step(x, pairs_, function,
                 {.history_count = static_cast<std::size_t>(*history_count),
                  .search = {.strong_wolfe = *line_search == "strong_wolfe", .max_evaluations = *max_evaluations},
                  .first_change = rate,
                  .largest_change = rate * *max_change},
                 at::get_num_threads());
        store(x, parameters);
        return first_loss;
    }

    fresco::TensorMap state() const override
    {
        fresco::TensorMap result;
        for (std::size_t i = 0; i < pairs_.size(); ++i)
        {
            result.emplace(fmt::format("change.{}", i), tensor(pairs_[i].change));
            result.emplace(fmt::format("difference.{}", i), tensor(pairs_[i].difference));
        }
        return result;
    }

    void restore(const fresco::TensorMap& state) override
    {
        pairs_.clear();
        if (state.size() > 2 * static_cast<std::size_t>(*history_count))
            does_not_fit("history_count");
        for (std::size_t i = 0; i < state.size() / 2; ++i)
            pairs_.push_back({entry(state, fmt::format("change.{}", i)), entry(state, fmt::format("difference.{}", i))});
    }

  private:
    [[noreturn]] static void does_not_fit(const std::string& what)
    {
        throw fresco::Error("the checkpoint's state of optimizer.lbfgs has no '" + what +
                            "' that fits this texture; remove the checkpoint folder");
    }

    static lb::Vector flattened(const std::vector<fresco::TextureParameter>& parameters)
    {
        lb::Vector x;
        for (const auto& parameter : parameters)
            x.insert(x.end(), parameter.values.data_ptr<float>(), parameter.values.data_ptr<float>() + parameter.values.numel());
        return x;
    }

    static void store(const lb::Vector& x, std::vector<fresco::TextureParameter>& parameters)
    {
        const float* next = x.data();
        for (auto& parameter : parameters)
        {
            std::copy(next, next + parameter.values.numel(), parameter.values.data_ptr<float>());
            next += parameter.values.numel();
        }
    }

    /// Adds the sparse gradients and the regularizer's to `gradient`; returns the regularizer.
    static double add_gradients(const std::vector<fresco::TextureParameter>& parameters,
                                const std::vector<fresco::SparseGradient>& sparse, double lambda_r, lb::Vector& gradient)
    {
        double penalty = 0;
        float* out = gradient.data();
        for (std::size_t i = 0; i < parameters.size(); ++i)
        {
            const auto& values = parameters[i].values;
            const auto texels = sparse.at(i).texels.contiguous();
            const auto slopes = sparse[i].values.contiguous();
            for (std::int64_t n = 0; n < texels.numel(); ++n)
                for (std::int64_t c = 0; c < 3; ++c)
                    out[3 * texels.data_ptr<std::int64_t>()[n] + c] += slopes.data_ptr<float>()[3 * n + c];
            // λ_r k mean(values²) and its derivative.
            const double factor = lambda_r * parameters[i].regularizer / static_cast<double>(values.numel());
            const float* value = values.data_ptr<float>();
            double squares = 0;
            for (std::int64_t n = 0; factor > 0 && n < values.numel(); ++n)
            {
                squares += static_cast<double>(value[n]) * static_cast<double>(value[n]);
                out[n] += static_cast<float>(2 * factor) * value[n];
            }
            penalty += factor * squares;
            out += values.numel();
        }
        return penalty;
    }

    static torch::Tensor tensor(const lb::Vector& vector)
    {
        auto result = at::empty({static_cast<std::int64_t>(vector.size())}, at::kFloat);
        std::copy(vector.begin(), vector.end(), result.data_ptr<float>());
        return result;
    }

    lb::Vector entry(const fresco::TensorMap& state, const std::string& name) const
    {
        const auto found = state.find(name);
        if (found == state.end() || found->second.scalar_type() != at::kFloat ||
            found->second.numel() != static_cast<std::int64_t>(size_))
            does_not_fit(name);
        const auto values = found->second.contiguous();
        return {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()};
    }

    std::size_t size_ = 0;
    std::deque<lb::Pair> pairs_;
};

}  // namespace

FRESCO_COMPONENT("optimizer.lbfgs", OptimizerLbfgs, fresco::OptimizerRule,
                 "L-BFGS with a line search: few, expensive steps, for small textures")
