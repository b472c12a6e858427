#include "evaluation.h"

#include "gradients.h"
#include "schedule.h"
#include "sheet.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros_like.h>
#include <c10/core/impl/VirtualGuardImpl.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <thread>
#include <utility>

namespace fresco::optimize
{
namespace
{

Evaluation without_gradients(std::size_t parameters)
{
    Evaluation result;
    for (std::size_t i = 0; i < parameters; ++i)
        result.gradients.push_back({at::empty({0}, at::kLong), at::empty({0, 3}, at::kFloat)});
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
void Evaluator::each_part(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name,
                          DisplayedValues& shown, const Work& work)
{
    noted_.clear();
    if (data.levels.empty())
        return;
    // Not sooner: a loss knows its network's default layers only once that network is prepared.
    if (demands_.empty())
        demands_ = demands_of(losses_);
    shown = displayed_values(space_, data.texture->render(), data.hidden);
    const auto picture = sent_to(shown.picture, device_);
    // The CPU takes one level after the other, in less memory.
    const std::size_t count = device_.is_cpu() ? 1 : data.levels.size();
    for (std::size_t first = 0; first < data.levels.size(); first += count)
    {
        auto where = fmt::format("step {}, view {}", step + 1, view_name);
        if (count == 1)
            where += fmt::format(" at {} px", data.levels[first].height_px);
        where += ": ";
        PixelBox box = data.levels[first].place;
        for (std::size_t i = first; i < first + count; ++i)
            box = {0, box.y0, std::max(box.x1, data.levels[i].place.x1), data.levels[i].place.y1};
        work(
            picture, box,
            [&](const torch::Tensor& image) {
                return terms_of(image, step, scheduled, data, {first, first + count}, where);
            },
            where);
    }
}

Evaluation Evaluator::evaluate(std::int64_t step, const ScheduledStep& scheduled, ViewData& data, const std::string& view_name,
                               std::size_t parameters, bool later)
{
    Evaluation result = without_gradients(parameters);
    DisplayedValues shown;
    torch::Tensor gradient;
    const auto take_gradient =
        [&](const torch::Tensor& picture, const PixelBox& box, const auto& terms_of, const std::string& where)
    {
        const auto image = cut(picture, box).contiguous().detach().set_requires_grad(true);
        // The way back needs none of the part's features: what the losses need of them, they keep.
        Terms terms = terms_of(image);
        torch::Tensor own;
        if (!terms.values.empty())
            own = torch::autograd::grad(terms.values, {image}, terms.factors, false, false, true)[0];
        if (!own.defined())
            return;
        own = own.detach().to(at::kFloat);
        // 0 times a finite number is 0, and nothing else gives 0.
        noted_.push_back({(own * 0).sum(), 1, where, "", ""});
        if (!gradient.defined())
            gradient = own.sizes() == picture.sizes() ? own : at::zeros_like(picture);
        if (!own.is_same(gradient))
            cut(gradient, box).copy_(own);
    };
    each_part(step, scheduled, data, view_name, shown, take_gradient);
    if (gradient.defined())
        result.gradients =
            data.texture->gradient(values_back(space_, shown.beyond, data.factor, gradient.to(shown.picture.device())));
    sent_.push_back(sent(step));
    result.loss = later ? std::numeric_limits<double>::quiet_NaN() : figures().loss;
    return result;
}

double Evaluator::loss(const ScheduledStep& scheduled, ViewData& data, const std::string& view_name)
{
    const at::NoGradGuard no_gradient;
    DisplayedValues shown;
    each_part(0, scheduled, data, view_name, shown,
              [](const torch::Tensor& picture, const PixelBox& box, const auto& terms_of, const std::string&)
              { terms_of(cut(picture, box).contiguous()); });
    sent_.push_back(sent(std::numeric_limits<std::int64_t>::max()));
    return figures().loss;
}

Evaluator::Terms Evaluator::terms_of(const torch::Tensor& picture, std::int64_t step, const ScheduledStep& scheduled,
                                     ViewData& data, std::pair<std::size_t, std::size_t> levels, const std::string& where)
{
    Terms terms;
    // Else the loader has laid them out.
    if (!device_.is_cpu() && data.sheets.empty())
        get_sheets_ready(data, demands_, device_);
    const auto share = [&](std::size_t level, const LossTerm& term) { return level_share(data, level, term, device_); };
    SheetLevels sheet(picture, data, demands_, share);
    std::vector<RenderedPart> parts;
    for (std::size_t i = levels.first; i < levels.second; ++i)
    {
        auto& level = data.levels[i];
        const int top = level.place.y0 - data.levels[levels.first].place.y0;
        const PixelBox box{0, top, level.place.x1, top + level.place.y1 - level.place.y0};
        const PartPlace place{data.numbers[i], step, static_cast<std::int64_t>(scheduled.view), scheduled.repeat,
                              mixed(seed_, static_cast<std::uint64_t>(step), static_cast<std::uint64_t>(data.numbers[i]))};
        parts.emplace_back(place, levels.second - levels.first == 1 ? picture : cut(picture, box), level, demands_,
                           OnSheet{&sheet, i});
    }
    for (const auto& [name, loss] : losses_)
    {
        auto* joint = dynamic_cast<JointLoss*>(loss.get());
        std::optional<std::vector<LossTerm>> together;
        if (joint != nullptr && sheet.has_all(loss->needs()))
            together = joint->evaluate_together(sheet);
        if (together)
            add_terms(
                *together, name, [&](const LossTerm&) { return *loss->weight; }, where, terms);
        for (std::size_t i = 0; i < parts.size() && !together; ++i)
            add_terms(
                loss->evaluate(parts[i]), name,
                [&](const LossTerm& term) { return *loss->weight * share(levels.first + i, term); }, where, terms);
    }
    set_factors(terms);
    return terms;
}

template <class Factor>
void Evaluator::add_terms(const std::vector<LossTerm>& of_loss, const std::string& name, const Factor& factor,
                          const std::string& where, Terms& terms)
{
    for (const auto& term : of_loss)
    {
        noted_.push_back({term.value.detach(), factor(term), where, name, term.layer});
        if (!term.value.requires_grad())
            continue;
        terms.values.push_back(term.value);
        terms.numbers.push_back(noted_.back().factor);
    }
}

void Evaluator::set_factors(Terms& terms)
{
    if (terms.values.empty())
        return;
    const auto type = terms.values.front().scalar_type();
    if (terms.numbers != last_factors_ || factors_.front().scalar_type() != type)
        factors_ = sent_to(at::tensor(terms.numbers, type), device_).unbind();
    last_factors_ = terms.numbers;
    for (std::size_t i = 0; i < factors_.size(); ++i)
        terms.factors.push_back(factors_[i].to(terms.values[i].scalar_type()).expand_as(terms.values[i]));
}

Evaluator::Sent Evaluator::sent(std::int64_t step)
{
    Sent result{step, std::exchange(noted_, {}), {}, {}};
    if (result.noted.empty())
        return result;
    std::vector<torch::Tensor> values;
    for (auto& noted : result.noted)
        values.push_back(std::exchange(noted.value, {}));
    result.values = at::stack(values);
    if (device_.is_cpu())
        return result;
    const auto there =
        std::exchange(result.values, at::empty(result.values.sizes(),
                                               result.values.options().device(at::kCPU).pinned_memory(device_.is_cuda())));
    result.values.copy_(there, true);
    result.arrived.emplace(device_.type());
    result.arrived->record(c10::impl::VirtualGuardImpl(device_.type()).getStream(device_));
    return result;
}

StepFigures Evaluator::settled(Sent sent)
{
    StepFigures figures{sent.step, 0, {}};
    while (sent.arrived && !sent.arrived->query())
        std::this_thread::sleep_for(std::chrono::microseconds(20));
    const auto numbers = sent.noted.empty() ? sent.values : sent.values.to(at::kDouble);
    for (std::size_t i = 0; i < sent.noted.size(); ++i)
    {
        const auto& noted = sent.noted[i];
        const double value = numbers.data_ptr<double>()[i];
        if (noted.loss.empty() && !std::isfinite(value))
            throw NotFinite(sent.step, noted.where + "the losses' gradient is not finite; lower 'rate' or the losses' weights");
        if (!std::isfinite(value))
            throw NotFinite(sent.step,
                            noted.where + "loss '" + noted.loss + "' is " + (std::isnan(value) ? "not a number" : "infinite") +
                                (noted.layer.empty() ? "" : " at layer " + noted.layer) + "; lower 'rate' or the loss's weight");
        if (noted.loss.empty())
            continue;
        figures.loss += value * noted.factor;
        figures.summands[noted.loss] += value * noted.factor;
    }
    return figures;
}

StepFigures Evaluator::figures()
{
    Sent first = std::move(sent_.front());
    sent_.pop_front();
    auto result = settled(std::move(first));
    for (const auto& [name, loss] : losses_)
        result.summands[name] += 0;
    summands_ = result.summands;
    return result;
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
        result.loss += evaluator.loss(scheduled, *data, source.name(view)) / count;
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
