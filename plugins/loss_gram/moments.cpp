#include "moments.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <fmt/format.h>

namespace gram
{
namespace
{

struct MomentsFunction : torch::autograd::Function<MomentsFunction>
{
    static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, const torch::Tensor& features)
    {
        context->save_for_backward({features});
        const auto count = static_cast<double>(features.size(1));
        return {fresco::ordered_mean(features, 1), fresco::matrix_product(features, features.t()).div_(count)};
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto features = context->get_saved_variables()[0];
        const auto count = static_cast<double>(features.size(1));
        torch::Tensor result;
        if (gradients[1].defined())
        {
            // Symmetric, so that the product can keep the order of the features in memory.
            const auto factor = (gradients[1] + gradients[1].t()).div_(count);
            result = features.is_contiguous() ? fresco::matrix_product(factor, features)
                                              : fresco::matrix_product(features.t(), factor).t();
        }
        else
            result = at::zeros_like(features);
        if (gradients[0].defined())
            result = result + (gradients[0] / count).unsqueeze(1);
        return {result};
    }
};

/// Some of the features, in memory as all are, and where they belong.
class Selection
{
  public:
    Selection(const torch::Tensor& features, const torch::Tensor& index)
        : pixels_in_rows_(!features.is_contiguous()), index_(index),
          chosen_(pixels_in_rows_ ? features.t().index_select(0, index).t() : features.index_select(1, index))
    {
    }

    torch::Tensor sum() const { return fresco::ordered_sum(chosen_, 1); }
    torch::Tensor products() const { return fresco::matrix_product(chosen_, chosen_.t()); }

    /// Their columns of `gradient` become `factor` (symmetric) times the features, plus `offset`.
    void write_gradient(const torch::Tensor& factor, const torch::Tensor& offset, torch::Tensor& gradient) const
    {
        if (pixels_in_rows_)
            gradient.t().index_copy_(0, index_, fresco::matrix_product(chosen_.t(), factor).add_(offset));
        else
            gradient.index_copy_(1, index_, fresco::matrix_product(factor, chosen_).add_(offset.unsqueeze(1)));
    }

  private:
    bool pixels_in_rows_;
    torch::Tensor index_;
    torch::Tensor chosen_;
};

/// C x N and the numbers of the fine and of the other columns -> mean and second moment of all, and of the fine ones.
struct BothMomentsFunction : torch::autograd::Function<BothMomentsFunction>
{
    static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, const torch::Tensor& features,
                                                  const torch::Tensor& fine, const torch::Tensor& others)
    {
        context->save_for_backward({features, fine, others});
        const auto count = static_cast<double>(features.size(1));
        const auto fine_count = static_cast<double>(fine.numel());
        torch::Tensor sum;
        torch::Tensor products;
        {
            const Selection selection(features, others);
            sum = selection.sum();
            products = selection.products();
        }
        const Selection selection(features, fine);
        const auto fine_sum = selection.sum();
        const auto fine_products = selection.products();
        return {(sum + fine_sum) / count, (products + fine_products) / count, fine_sum / fine_count, fine_products / fine_count};
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto saved = context->get_saved_variables();
        const auto& features = saved[0];
        const auto count = static_cast<double>(features.size(1));
        const auto fine_count = static_cast<double>(saved[1].numel());
        const auto factor = (gradients[1] + gradients[1].t()).div_(count);
        const auto offset = gradients[0] / count;
        auto result = at::empty_strided(features.sizes(), features.strides(), features.options());
        Selection(features, saved[2]).write_gradient(factor, offset, result);
        Selection(features, saved[1])
            .write_gradient(factor + (gradients[3] + gradients[3].t()).div_(fine_count), offset + gradients[2] / fine_count,
                            result);
        return {result, torch::Tensor(), torch::Tensor()};
    }
};

torch::Tensor sum_of_squares(const torch::Tensor& x)
{
    return fresco::ordered_sum(x * x);
}

}  // namespace

Moments moments(const torch::Tensor& features)
{
    const auto values = MomentsFunction::apply(features);
    return {values[0], values[1]};
}

MomentsOfBoth moments_of_both(const torch::Tensor& given, const fresco::FineColumns& columns)
{
    const auto features = given.t().is_contiguous() ? given : given.contiguous();
    if (columns.fine.numel() == 0)
        return {moments(features), std::nullopt};
    if (columns.others.numel() == 0)
    {
        const auto all = moments(features);
        return {all, all};
    }
    const auto values = BothMomentsFunction::apply(features, columns.fine, columns.others);
    return {{values[0], values[1]}, Moments{values[2], values[3]}};
}

torch::Tensor covariance(const Moments& moments)
{
    return moments.second - moments.mean.unsqueeze(1) * moments.mean.unsqueeze(0);
}

torch::Tensor mean_square_difference(const torch::Tensor& a, const torch::Tensor& target)
{
    return sum_of_squares(a - target) / static_cast<double>(a.numel());
}

torch::Tensor relative_square_difference(const torch::Tensor& a, const torch::Tensor& target)
{
    // As a tensor: another device need not be waited for.
    const auto scale = sum_of_squares(target);
    return sum_of_squares(a - target) / at::where(scale > 0, scale, at::ones_like(scale));
}

namespace
{

constexpr std::int64_t parts_per_entry = 3;

torch::Tensor entry(const fresco::TensorMap& state, const std::string& name)
{
    const auto found = state.find(name);
    if (found == state.end())
        throw fresco::Error("loss.gram: the checkpoint lacks '" + name + "'; remove the checkpoint folder and run again");
    return found->second;
}

}  // namespace

Moments ViewAverage::average(const std::string& name, const Visit& visit, const Moments& current)
{
    auto& kept = kept_[name];
    const bool same_visit =
        !kept.empty() && kept.back().view == visit.view && (visit.repeat > 0 || kept.back().step == visit.step);
    if (same_visit)
        kept.pop_back();
    while (kept.size() >= static_cast<std::size_t>(count_))
        kept.pop_front();
    Moments sum = current;
    for (const auto& earlier : kept)
    {
        sum.mean = sum.mean + earlier.moments.mean.to(current.mean.options());
        sum.second = sum.second + earlier.moments.second.to(current.second.options());
    }
    kept.push_back({visit.step, visit.view, {current.mean.detach(), current.second.detach()}});
    const auto count = static_cast<double>(kept.size());
    return {sum.mean / count, sum.second / count};
}

fresco::TensorMap ViewAverage::state() const
{
    fresco::TensorMap state;
    for (const auto& [name, kept] : kept_)
    {
        std::int64_t number = 0;
        for (const auto& each : kept)
        {
            const auto prefix = fmt::format("{}.{}", name, number++);
            state[prefix + ".visit"] = at::tensor({each.step, each.view}, at::kLong);
            state[prefix + ".mean"] = each.moments.mean.cpu().clone();
            state[prefix + ".second"] = each.moments.second.cpu().clone();
        }
    }
    return state;
}

void ViewAverage::restore(const fresco::TensorMap& state)
{
    kept_.clear();
    std::int64_t taken = 0;
    const std::string first = ".0.visit";
    for (const auto& [key, unused] : state)
    {
        if (!key.ends_with(first))
            continue;
        const auto name = key.substr(0, key.size() - first.size());
        for (int number = 0; state.contains(fmt::format("{}.{}.visit", name, number)); ++number)
        {
            const auto prefix = fmt::format("{}.{}", name, number);
            const auto visit = entry(state, prefix + ".visit");
            if (visit.numel() != 2 || visit.scalar_type() != at::kLong)
                throw fresco::Error("loss.gram: the checkpoint's '" + prefix +
                                    ".visit' is not two whole numbers; remove the checkpoint folder and run again");
            kept_[name].push_back({visit[0].item<std::int64_t>(),
                                   visit[1].item<std::int64_t>(),
                                   {entry(state, prefix + ".mean").clone(), entry(state, prefix + ".second").clone()}});
            taken += parts_per_entry;
        }
        if (kept_[name].size() > static_cast<std::size_t>(count_))
            throw fresco::Error(
                "loss.gram: the checkpoint was made with a larger `average_views_count`; remove its folder and run again");
    }
    if (taken != static_cast<std::int64_t>(state.size()))
        throw fresco::Error("loss.gram: the checkpoint holds entries of another loss; remove its folder and run again");
}

}  // namespace gram
