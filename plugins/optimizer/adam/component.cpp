#include "adam.h"

#include <fresco/option.h>
#include <fresco/stage.h>
#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/tensor_memory.h>

#include <ATen/Parallel.h>
#include <ATen/ops/full.h>

#include <fmt/format.h>
#include <string>

namespace
{

class OptimizerAdam final : public fresco::OptimizerRule
{
    fresco::Option<double> beta1{this, "beta1", 0.9, fresco::range(0, 0.999999), "Decay of the gradient's moving mean"};
    fresco::Option<double> beta2{this, "beta2", 0.999, fresco::range(0, 0.999999999), "Decay of the moving mean of its square"};
    fresco::Option<double> epsilon{this, "epsilon", 1e-8, fresco::range(1e-30, 1),
                                   "Added to the root of the moving mean square, in units of the gradient"};
    fresco::Option<std::string> mode{
        this, "mode", "dense", fresco::one_of({"dense", "visible"}),
        "dense: textbook Adam, every texel in every step; visible: only the texels the step's view sees"};

  public:
    bool runs_on(const torch::Device&) const override { return true; }

    void attach(const std::vector<fresco::TextureParameter>& parameters) override
    {
        step_ = 0;
        blocks_.clear();
        for (const auto& parameter : parameters)
        {
            State state;
            state.first = zeros_beside(parameter.values, parameter.values.sizes(), at::kFloat);
            state.second = zeros_beside(parameter.values, parameter.values.sizes(), at::kFloat);
            if (visible())
                state.steps = zeros_beside(parameter.values, {parameter.values.size(0)}, at::kInt);
            blocks_.push_back(std::move(state));
        }
    }

    double step(std::vector<fresco::TextureParameter>& parameters, const fresco::Evaluate& evaluate, double rate,
                double lambda_r) override
    {
        const auto evaluation = evaluate();
        ++step_;
        const fresco::adam::Constants constants{.beta1 = *beta1, .beta2 = *beta2, .epsilon = *epsilon};
        std::vector<double> pulls;
        // The derivative of λ_r k mean(values²).
        for (const auto& parameter : parameters)
            pulls.push_back(2 * lambda_r * parameter.regularizer / static_cast<double>(parameter.values.numel()));
        if (!parameters.empty() && !parameters[0].values.device().is_cpu())
        {
            step_there(parameters, evaluation.gradients, rate, pulls, constants);
            return evaluation.loss;
        }
        for (std::size_t i = 0; i < parameters.size(); ++i)
        {
            auto& parameter = parameters[i];
            auto& state = blocks_[i];
            const double pull = pulls[i];
            const auto texels = evaluation.gradients.at(i).texels.contiguous();
            const auto values = evaluation.gradients[i].values.contiguous();
            const fresco::adam::Gradient gradient{{texels.data_ptr<std::int64_t>(), static_cast<std::size_t>(texels.numel())},
                                                  values.data_ptr<float>()};
            const auto block = block_of(parameter, state);
            if (visible())
                fresco::adam::step_visible(block, gradient, rate, pull, constants, at::get_num_threads());
            else
                fresco::adam::step_dense(block, gradient, step_, rate, pull, constants, at::get_num_threads());
        }
        return evaluation.loss;
    }

    fresco::TensorMap state() const override
    {
        fresco::TensorMap result{{"step", at::full({}, step_, at::kLong)}};
        for (std::size_t i = 0; i < blocks_.size(); ++i)
        {
            result.emplace(fmt::format("first.{}", i), blocks_[i].first);
            result.emplace(fmt::format("second.{}", i), blocks_[i].second);
            if (visible())
                result.emplace(fmt::format("steps.{}", i), blocks_[i].steps);
        }
        return result;
    }

    void restore(const fresco::TensorMap& state) override
    {
        step_ = state.at("step").item<std::int64_t>();
        for (std::size_t i = 0; i < blocks_.size(); ++i)
        {
            auto& block = blocks_[i];
            fresco::write_values(state.at(fmt::format("first.{}", i)), block.first);
            fresco::write_values(state.at(fmt::format("second.{}", i)), block.second);
            if (visible())
                fresco::write_values(state.at(fmt::format("steps.{}", i)), block.steps);
            block.moved.clear();
        }
    }

  private:
    struct State
    {
        torch::Tensor first;
        torch::Tensor second;
        torch::Tensor steps;              ///< Defined only in the mode `visible`.
        std::vector<std::uint8_t> moved;  ///< As adam::Block has it; empty: not known.
    };

    /// On another device than the CPU.
    void step_there(const std::vector<fresco::TextureParameter>& parameters, std::vector<fresco::SparseGradient> gradients,
                    double rate, const std::vector<double>& pulls, const fresco::adam::Constants& constants) const
    {
        std::vector<fresco::adam::TensorBlock> blocks;
        for (std::size_t i = 0; i < parameters.size(); ++i)
        {
            const auto device = parameters[i].values.device();
            blocks.push_back({parameters[i].values, blocks_[i].first, blocks_[i].second, blocks_[i].steps});
            // An empty gradient, of a view without pixels in any level, is on the CPU.
            gradients.at(i) = {gradients[i].texels.to(device), gradients[i].values.to(device)};
        }
        if (!visible())
            return fresco::adam::step_dense(blocks, gradients, pulls, step_, rate, constants);
        for (std::size_t i = 0; i < blocks.size(); ++i)
            fresco::adam::step_visible(blocks[i], gradients[i].texels, gradients[i].values, rate, pulls[i], constants);
    }

    static torch::Tensor zeros_beside(const torch::Tensor& values, at::IntArrayRef shape, at::ScalarType type)
    {
        return values.device().is_cpu() ? fresco::lazy_zeros(shape, type) : at::zeros(shape, values.options().dtype(type));
    }

    bool visible() const { return *mode == "visible"; }

    /// The first step after attach() or restore() learns which texels differ from zero: their values may be set until then.
    fresco::adam::Block block_of(const fresco::TextureParameter& parameter, State& state) const
    {
        fresco::adam::Block block{parameter.values.data_ptr<float>(), state.first.data_ptr<float>(),
                                  state.second.data_ptr<float>(), visible() ? state.steps.data_ptr<std::int32_t>() : nullptr,
                                  static_cast<std::size_t>(parameter.values.size(0))};
        if (visible())
            return block;
        const bool known = !state.moved.empty();
        state.moved.resize(fresco::adam::run_count(block.texels));
        block.moved = state.moved.data();
        if (!known)
            fresco::adam::mark_moved(block, at::get_num_threads());
        return block;
    }

    std::int64_t step_ = 0;
    std::vector<State> blocks_;
};

}  // namespace

FRESCO_COMPONENT("optimizer.adam", OptimizerAdam, fresco::OptimizerRule, "Adam, on all texels or only the visible ones")
