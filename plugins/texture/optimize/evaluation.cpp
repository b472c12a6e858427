#include "evaluation.h"

#include "gradients.h"
#include "schedule.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/tensor.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace fresco::optimize
{
namespace
{

std::vector<SparseGradient> no_gradients(std::size_t parameters)
{
    std::vector<SparseGradient> result;
    for (std::size_t i = 0; i < parameters; ++i)
        result.push_back({at::empty({0}, at::kLong), at::empty({0, 3}, at::kFloat)});
    return result;
}

/// ŵ_l of one term: of the pixels, or of the cells of its layer's grid.
double level_share(ViewData& data, std::size_t level, const LossTerm& term, const torch::Device& device)
{
    if (!is_released(data.protocol) || term.network == nullptr)
        return data.levels[level].share;
    const int stride = term.network->layer(term.layer).stride;
    double sum = 0;
    double own = 0;
    for (std::size_t i = 0; i < data.levels.size(); ++i)
    {
        const auto& mask = grid_of(data.levels[i], stride, device);
        const auto cells = static_cast<double>(std::max<std::int64_t>(1, mask.cell_count()));
        const double covered = static_cast<double>(mask.chosen_count()) / cells;
        sum += covered;
        if (i == level)
            own = covered;
    }
    return sum > 0 ? own / sum : 0;
}

}  // namespace

Evaluator::Evaluator(const std::map<std::string, std::shared_ptr<Loss>>& losses, ValueSpace space, torch::Device device,
                     std::uint64_t seed)
    : losses_(losses), space_(space), device_(device), seed_(seed)
{
}

template <class Work>
void Evaluator::each_level(std::int64_t step, const ScheduledStep& scheduled, const ViewData& data, const std::string& view_name,
                           const Work& work)
{
    // Not sooner: a loss knows its network's default layers only once that network is prepared.
    if (demands_.empty())
        demands_ = demands_of(losses_);
    summands_.clear();
    noted_.clear();
    for (std::size_t i = 0; i < data.levels.size(); ++i)
    {
        const int level = data.numbers[i];
        const PartPlace place{level, step, static_cast<std::int64_t>(scheduled.view), scheduled.repeat,
                              mixed(seed_, static_cast<std::uint64_t>(step), static_cast<std::uint64_t>(level))};
        work(place, i, fmt::format("step {}, view {} at {} px: ", step + 1, view_name, data.levels[i].height_px));
    }
}

Evaluation Evaluator::evaluate(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name,
                               std::size_t parameters)
{
    Evaluation result;
    std::vector<std::vector<SparseGradient>> there;
    each_level(step, scheduled, data, view_name,
               [&](const PartPlace& place, std::size_t level, const std::string& where)
               {
                   auto gradients = level_gradients(place, data, level, where);
                   if (device_.is_cpu())
                       result.loss += settled();
                   if (!gradients.empty() && !gradients[0].values.device().is_cpu())
                       there.push_back(std::move(gradients));
                   else if (result.gradients.empty())
                       result.gradients = std::move(gradients);
                   else
                       for (std::size_t p = 0; p < gradients.size() && p < result.gradients.size(); ++p)
                           result.gradients[p] = sparse_sum(result.gradients[p], gradients[p]);
               });
    if (!there.empty())
        result.gradients = data.gradient_union.sum(there);
    result.loss += settled();
    if (result.gradients.empty())
        result.gradients = no_gradients(parameters);
    return result;
}

double Evaluator::loss(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name)
{
    const at::NoGradGuard no_gradient;
    each_level(step, scheduled, data, view_name,
               [&](const PartPlace& place, std::size_t number, const std::string& where)
               {
                   torch::Tensor stored;
                   RenderedPart part(place, displayed(data.levels[number], stored), data.levels[number], demands_);
                   terms_of(
                       part, [&](const LossTerm& term) { return level_share(data, number, term, device_); }, where);
               });
    return settled();
}

torch::Tensor Evaluator::displayed(LevelData& level, torch::Tensor& stored) const
{
    stored = level.view->render();
    // All that is seen, also beyond the level: features near its border look there.
    return sent_to(displayed_values(space_, stored, level.valid), device_);
}

std::vector<SparseGradient> Evaluator::level_gradients(const PartPlace& place, ViewData& data, std::size_t level_number,
                                                       const std::string& where)
{
    auto& level = data.levels[level_number];
    torch::Tensor stored;
    const auto image = displayed(level, stored).detach().set_requires_grad(true);
    Terms terms;
    {
        RenderedPart part(place, image, level, demands_);
        terms = terms_of(
            part, [&](const LossTerm& term) { return level_share(data, level_number, term, device_); }, where);
    }
    // The way back needs none of the part's features: what the losses need of them, they keep.
    torch::Tensor gradient;
    if (!terms.values.empty())
        gradient = torch::autograd::grad(terms.values, {image}, terms.factors, false, false, true)[0];
    if (!gradient.defined())
        return {};
    terms = {};
    return texture_gradients(level, stored, gradient.detach(), where);
}

std::vector<SparseGradient> Evaluator::texture_gradients(const LevelData& level, const torch::Tensor& stored,
                                                         torch::Tensor gradient, const std::string& where)
{
    gradient = gradient.to(at::kFloat);
    // 0 times a finite number is 0, and nothing else gives 0.
    noted_.push_back({(gradient * 0).sum(), 1, where, "", ""});
    return level.view->gradient(values_back(space_, stored, level.factor, gradient.to(stored.device())));
}

Evaluator::Terms Evaluator::terms_of(Part& part, const std::function<double(const LossTerm&)>& share, const std::string& where)
{
    Terms terms;
    std::vector<double> factors;
    for (const auto& [name, component] : losses_)
    {
        summands_[name] += 0;
        for (const auto& term : component->evaluate(part))
        {
            const double factor = *component->weight * share(term);
            noted_.push_back({term.value.detach(), factor, where, name, term.layer});
            if (!term.value.requires_grad())
                continue;
            terms.values.push_back(term.value);
            factors.push_back(factor);
        }
    }
    if (!factors.empty())
        terms.factors = sent_to(at::tensor(factors, terms.values.front().scalar_type()), device_).unbind();
    for (std::size_t i = 0; i < factors.size(); ++i)
        terms.factors[i] = terms.factors[i].to(terms.values[i].scalar_type()).expand_as(terms.values[i]);
    return terms;
}

double Evaluator::settled()
{
    if (noted_.empty())
        return 0;
    std::vector<torch::Tensor> values;
    for (const auto& noted : noted_)
        values.push_back(noted.value);
    const auto numbers = at::stack(values).to(at::kCPU, at::kDouble);
    double sum = 0;
    const double* value = numbers.data_ptr<double>();
    for (const auto& noted : std::exchange(noted_, {}))
    {
        if (noted.loss.empty() && !std::isfinite(*value))
            throw NotFinite(noted.where + "the losses' gradient is not finite; lower 'rate' or the losses' weights");
        if (!std::isfinite(*value))
            throw NotFinite(noted.where + "loss '" + noted.loss + "' is " + (std::isnan(*value) ? "not a number" : "infinite") +
                            (noted.layer.empty() ? "" : " at layer " + noted.layer) + "; lower 'rate' or the loss's weight");
        if (!noted.loss.empty())
        {
            sum += *value * noted.factor;
            summands_[noted.loss] += *value * noted.factor;
        }
        ++value;
    }
    return sum;
}

void report_balance(const std::map<std::string, std::shared_ptr<Loss>>& losses, const std::map<std::string, double>& summands,
                    bool begins_empty, RunContext& run)
{
    double style = 0;
    double content = 0;
    for (const auto& [name, loss] : losses)
    {
        const auto needs = loss->needs().features;
        const auto found = summands.find(name);
        if (needs.empty() || found == summands.end())
            continue;
        (std::ranges::any_of(needs, &LossNeeds::Layers::camera) ? content : style) += found->second;
    }
    if (!(style > 0 && content > 0))
        return;
    const double ratio = style / content;
    run.report("initial_style_over_content", ratio);
    if (begins_empty && (ratio < 0.3 || ratio > 8))
        run.warning(fmt::format(
            "at the first step style counts {:.3g} times as much as content, where 0.3 to 8 is usual: the texture will "
            "show little of the {}; does the scale of the network's weights (fresco weights inspect) fit the losses' "
            "weights?",
            ratio, ratio < 1 ? "style" : "room"));
}

ViewSplit split_views(const std::vector<std::size_t>& views, int count)
{
    const auto wanted = static_cast<std::size_t>(count);
    if (wanted >= views.size() && wanted > 0)
        throw Error(
            fmt::format("held_out_count is {}, but only {} views see the mesh: leave some to optimize for", count, views.size()));
    ViewSplit split;
    std::size_t next = 0;
    for (std::size_t i = 0; i < views.size(); ++i)
    {
        // The middles of `wanted` equal stretches of the recording.
        const bool held = next < wanted && i == (2 * next + 1) * views.size() / (2 * wanted);
        (held ? split.held_out : split.trained).push_back(views[i]);
        next += held ? 1 : 0;
    }
    return split;
}

bool has_stopped_falling(const std::vector<HeldOutLoss>& history, double gain)
{
    constexpr std::size_t window = 3;
    if (gain <= 0 || history.size() <= window)
        return false;
    const auto smallest = [](auto begin, auto end)
    { return std::min_element(begin, end, [](const auto& a, const auto& b) { return a.loss < b.loss; })->loss; };
    const auto recent = history.end() - static_cast<std::ptrdiff_t>(window);
    return smallest(recent, history.end()) > (1 - gain) * smallest(history.begin(), recent);
}

HeldOutLoss held_out_loss(Evaluator& evaluator, std::int64_t step, const ViewSource& source,
                          const std::vector<std::size_t>& views,
                          const std::function<std::unique_ptr<ViewData>(std::size_t)>& load,
                          const std::map<std::string, std::shared_ptr<Loss>>& losses, const Progress& progress)
{
    std::map<std::string, TensorMap> states;
    for (const auto& [name, loss] : losses)
        states.emplace(name, loss->state());
    HeldOutLoss result{step, 0, std::vector<double>(losses.size())};
    const auto count = static_cast<double>(views.size());
    for (const auto view : views)
    {
        progress.check_canceled();
        const auto data = load(view);
        ScheduledStep scheduled;
        scheduled.view = view;
        result.loss += evaluator.loss(0, scheduled, *data, source.name(view)) / count;
        std::size_t part = 0;
        for (const auto& [name, loss] : losses)
        {
            const auto found = evaluator.summands().find(name);
            result.parts[part++] += found == evaluator.summands().end() ? 0.0 : found->second / count;
            loss->restore(states.at(name));
        }
    }
    return result;
}

}  // namespace fresco::optimize
