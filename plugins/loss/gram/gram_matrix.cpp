#include "gram_matrix.h"

#include <fresco/error.h>
#include <fresco/math.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace gram
{
namespace
{

/// F Fᵀ. On the CPU the blocks below the diagonal are those above it, turned.
torch::Tensor products(const torch::Tensor& features)
{
    constexpr std::int64_t block = 64;
    const auto channels = features.size(0);
    if (!features.device().is_cpu() || channels <= block)
        return fresco::matrix_product(features, features.t());
    auto result = at::empty({channels, channels}, features.options());
    for (std::int64_t first = 0; first < channels; first += block)
    {
        const auto count = std::min(block, channels - first);
        const auto right =
            fresco::matrix_product(features.narrow(0, first, count), features.narrow(0, first, channels - first).t());
        result.narrow(0, first, count).narrow(1, first, channels - first).copy_(right);
        result.narrow(1, first, count).narrow(0, first, channels - first).copy_(right.t());
    }
    return result;
}

/// `gradient` + its transpose, or nothing.
torch::Tensor symmetric(const torch::Tensor& gradient, double count)
{
    return gradient.defined() ? (gradient + gradient.t()).div_(count) : gradient;
}

torch::Tensor sum_of(const torch::Tensor& a, const torch::Tensor& b)
{
    if (!a.defined() || !b.defined())
        return a.defined() ? a : b;
    return a + b;
}

fresco::MatrixView view(const torch::Tensor& matrix)
{
    return {matrix.data_ptr<float>(), static_cast<std::size_t>(matrix.size(0)), static_cast<std::size_t>(matrix.size(1)),
            matrix.stride(0), matrix.stride(1)};
}

/// Writes `factor` (symmetric, if defined) times `features` to `gradient`, which has the features' place in memory.
void write_gradient(const torch::Tensor& factor, const torch::Tensor& features, const torch::Tensor& gradient)
{
    // Symmetric, so that the product can keep the order of the features in memory.
    const bool turned = features.t().is_contiguous();
    const auto& a = turned ? features.t() : factor;
    const auto& b = turned ? factor : features;
    auto out = turned ? gradient.t() : gradient;
    if (!factor.defined())
        out.zero_();
    else if (!factor.device().is_cpu())
        at::mm_out(out, a, b);
    else if (out.is_contiguous() && out.scalar_type() == at::kFloat)
        fresco::multiply_matrices(view(a), view(b), out.data_ptr<float>(), at::get_num_threads());
    else
        out.copy_(fresco::matrix_product(a, b));
}

/// C x N features, the first `fine_count` of them fine -> the matrix of all and, if any, of the fine ones.
struct GramFunction : torch::autograd::Function<GramFunction>
{
    static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, const torch::Tensor& features,
                                                  std::int64_t fine_count)
    {
        context->save_for_backward({features});
        context->saved_data["fine_count"] = fine_count;
        context->set_materialize_grads(false);
        const auto count = static_cast<double>(features.size(1));
        const auto others = features.narrow(1, fine_count, features.size(1) - fine_count);
        if (fine_count == 0)
            return {products(others).div_(count)};
        const auto fine_products = products(features.narrow(1, 0, fine_count));
        return {(products(others) + fine_products).div_(count), fine_products / static_cast<double>(fine_count)};
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto features = context->get_saved_variables()[0];
        const auto fine_count = context->saved_data["fine_count"].toInt();
        const auto factor = symmetric(gradients.at(0), static_cast<double>(features.size(1)));
        const auto result = at::empty_strided(features.sizes(), features.strides(), features.options());
        const auto write = [&](std::int64_t first, std::int64_t number, const torch::Tensor& of)
        { write_gradient(of, features.narrow(1, first, number), result.narrow(1, first, number)); };
        if (fine_count < features.size(1))
            write(fine_count, features.size(1) - fine_count, factor);
        if (fine_count > 0)
            write(0, fine_count, sum_of(factor, symmetric(gradients.at(1), static_cast<double>(fine_count))));
        return {result, torch::Tensor()};
    }
};

torch::Tensor sum_of_squares(const torch::Tensor& x)
{
    return x.device().is_cpu() ? fresco::ordered_sum(x * x) : at::dot(x.flatten(), x.flatten());
}

/// Calls visit(first column, their number) for what is fine in each level, and for what is not.
template <class Visit>
void each_run(const std::vector<fresco::LevelColumns>& levels, const Visit& visit)
{
    std::int64_t first = 0;
    for (const auto& level : levels)
        for (const auto count : {level.fine_count, level.count - level.fine_count})
        {
            if (count > 0)
                visit(first, count);
            first += count;
        }
}

/// See gram_distance(). With the targets and then the products of each run as the rows of B, the distance is ‖W B‖²: W holds,
/// for each matrix that is compared, 1 for its target and -1 / N for its runs, times the root of its weight.
struct GramDistance : torch::autograd::Function<GramDistance>
{
    static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& features,
                                 const std::vector<fresco::LevelColumns>& levels, const torch::Tensor& targets,
                                 const torch::Tensor& weights)
    {
        const auto channels = features.size(0);
        const auto of_runs = weights.narrow(1, targets.size(0), weights.size(1) - targets.size(0));
        const auto products_of_runs = at::empty({of_runs.size(1), channels, channels}, features.options());
        std::vector<std::int64_t> runs;
        each_run(levels,
                 [&](std::int64_t first, std::int64_t count)
                 {
                     const auto run = features.narrow(1, first, count);
                     auto to = products_of_runs[std::ssize(runs) / 2];
                     if (features.device().is_cpu())
                         to.copy_(products(run));
                     else
                         at::mm_out(to, run, run.t());
                     runs.insert(runs.end(), {first, count});
                 });
        const auto differences = fresco::matrix_product(weights.narrow(1, 0, targets.size(0)), targets.flatten(1));
        if (features.device().is_cpu())
            differences.add_(fresco::matrix_product(of_runs, products_of_runs.flatten(1)));
        else
            differences.addmm_(of_runs, products_of_runs.flatten(1));
        const torch::autograd::variable_list saved{features, differences, of_runs};
        context->save_for_backward(saved);
        context->saved_data["runs"] = runs;
        return sum_of_squares(differences);
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto saved = context->get_saved_variables();
        const auto& features = saved[0];
        const auto runs = context->saved_data["runs"].toIntVector();
        const auto count = std::ssize(runs) / 2;
        const auto channels = features.size(0);
        // Derivative of ‖T - F Fᵀ / N‖²; the difference is symmetric.
        const auto slopes = fresco::matrix_product(saved[2].t(), saved[1] * (4 * gradients[0])).view({count, channels, channels});
        const auto result = at::empty_strided(features.sizes(), features.strides(), features.options());
        for (std::int64_t i = 0; i < count; ++i)
        {
            const auto first = runs[static_cast<std::size_t>(2 * i)];
            const auto number = runs[static_cast<std::size_t>(2 * i + 1)];
            write_gradient(slopes[i], features.narrow(1, first, number), result.narrow(1, first, number));
        }
        return {result, torch::Tensor(), torch::Tensor(), torch::Tensor()};
    }
};

/// Features, or channels, in rows: as they lie in memory, if they do.
torch::Tensor in_rows(const torch::Tensor& features)
{
    return features.t().is_contiguous() ? features : features.contiguous();
}

}  // namespace

torch::Tensor gram_matrix(const torch::Tensor& features)
{
    return gram_of_both(features, 0).all;
}

torch::Tensor gram_weights(const std::vector<fresco::LevelColumns>& levels, bool has_fine_target, double scale)
{
    std::vector<std::vector<double>> rows;
    std::size_t run = has_fine_target ? 2 : 1;
    std::size_t columns = run;
    each_run(levels, [&](std::int64_t, std::int64_t) { ++columns; });
    for (const auto& level : levels)
    {
        const double root = std::sqrt(level.share * scale);
        std::vector<double> all(columns);
        std::vector<double> fine(columns);
        all[0] = root;
        for (const auto count : {level.fine_count, level.count - level.fine_count})
            if (count > 0)
                all[run++] = -root / static_cast<double>(level.count);
        if (level.count > 0)
            rows.push_back(all);
        if (level.fine_count > 0 && has_fine_target)
        {
            fine[1] = root;
            fine[run - (level.fine_count < level.count ? 2 : 1)] = -root / static_cast<double>(level.fine_count);
            rows.push_back(fine);
        }
    }
    const auto weights = at::empty({std::ssize(rows), static_cast<std::int64_t>(columns)}, at::kDouble);
    double* to = weights.data_ptr<double>();
    for (const auto& row : rows)
        to = std::copy(row.begin(), row.end(), to);
    return weights;
}

torch::Tensor gram_distance(const torch::Tensor& features, const std::vector<fresco::LevelColumns>& levels,
                            const torch::Tensor& targets, const torch::Tensor& weights)
{
    return GramDistance::apply(in_rows(features), levels, targets, weights);
}

GramOfBoth gram_of_both(const torch::Tensor& features, std::int64_t fine_count)
{
    const auto values = GramFunction::apply(in_rows(features), fine_count);
    return {values[0], fine_count > 0 ? std::optional(values[1]) : std::nullopt};
}

torch::Tensor mean_square_difference(const torch::Tensor& a, const torch::Tensor& target)
{
    return sum_of_squares(a - target) / static_cast<double>(a.numel());
}

torch::Tensor ViewAverage::average(const std::string& name, const Visit& visit, const torch::Tensor& current)
{
    auto& kept = kept_[name];
    const bool same_visit =
        !kept.empty() && kept.back().view == visit.view && (visit.repeat > 0 || kept.back().step == visit.step);
    if (same_visit)
        kept.pop_back();
    while (kept.size() >= static_cast<std::size_t>(count_))
        kept.pop_front();
    torch::Tensor sum = current;
    for (const auto& earlier : kept)
        sum = sum + earlier.matrix.to(current.options());
    kept.push_back({visit.step, visit.view, current.detach()});
    return sum / static_cast<double>(kept.size());
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
            state[prefix + ".matrix"] = each.matrix.cpu().clone();
        }
    }
    return state;
}

void ViewAverage::restore(const fresco::TensorMap& state)
{
    kept_.clear();
    const std::string first = ".0.visit";
    for (const auto& [key, unused] : state)
    {
        if (!key.ends_with(first))
            continue;
        const auto name = key.substr(0, key.size() - first.size());
        for (int number = 0; state.contains(fmt::format("{}.{}.visit", name, number)); ++number)
        {
            const auto prefix = fmt::format("{}.{}", name, number);
            const auto visit = state.at(prefix + ".visit");
            kept_[name].push_back(
                {visit[0].item<std::int64_t>(), visit[1].item<std::int64_t>(), state.at(prefix + ".matrix").clone()});
        }
    }
}

}  // namespace gram
