#include "held_out.h"

#include <fresco/error.h>

#include <algorithm>
#include <limits>

namespace fresco::optimize
{

ViewSplit split_views(const std::vector<std::size_t>& views, int count)
{
    const auto wanted = static_cast<std::size_t>(count);
    if (wanted >= views.size() && wanted > 0)
        throw Error("held_out_count is " + std::to_string(count) + ", but only " + std::to_string(views.size()) +
                    " views see the mesh: leave some to optimise for");
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

bool has_stopped_falling(const std::vector<HeldOutLoss>& history, double gain, std::size_t window)
{
    if (gain <= 0 || history.size() <= window)
        return false;
    const auto smallest = [](auto begin, auto end)
    { return std::min_element(begin, end, [](const auto& a, const auto& b) { return a.loss < b.loss; })->loss; };
    const auto recent = history.end() - static_cast<std::ptrdiff_t>(window);
    return smallest(recent, history.end()) > (1 - gain) * smallest(history.begin(), recent);
}

HeldOutViews::HeldOutViews(const ViewSource& source, const std::vector<std::size_t>& views, const TextureRepresentation& texture,
                           const LevelRules& rules, const torch::Device& device)
    : source_(source)
{
    for (const auto view : views)
    {
        views_.push_back(load_view(source, view, texture, rules));
        move_to(*views_.back(), device);
    }
}

double HeldOutViews::loss(Evaluator& evaluator, std::int64_t step, const std::map<std::string, std::shared_ptr<Loss>>& losses)
{
    std::map<std::string, TensorMap> states;
    for (const auto& [name, loss] : losses)
        states.emplace(name, loss->state());
    double sum = 0;
    for (const auto& data : views_)
    {
        ScheduledStep scheduled;
        scheduled.view = data->view;
        sum += evaluator.loss(step, scheduled, *data, source_.name(data->view));
    }
    for (const auto& [name, loss] : losses)
        loss->restore(states.at(name));
    return views_.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(views_.size());
}

}  // namespace fresco::optimize
