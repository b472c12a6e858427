#include "held_out.h"

#include <fresco/error.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::optimize
{

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
                           const LevelRules& rules, const torch::Device& device, bool texture_too)
    : source_(source), views_(views), texture_(texture), rules_(rules), device_(device), texture_too_(texture_too)
{
}

HeldOutLoss HeldOutViews::measured(Evaluator& evaluator, std::int64_t step,
                                   const std::map<std::string, std::shared_ptr<Loss>>& losses, const Progress& progress)
{
    std::map<std::string, TensorMap> states;
    for (const auto& [name, loss] : losses)
        states.emplace(name, loss->state());
    HeldOutLoss result{step, 0, std::vector<double>(losses.size())};
    const auto count = static_cast<double>(views_.size());
    for (const auto view : views_)
    {
        progress.check_canceled();
        const auto data = load_view(source_, view, texture_, rules_);
        move_to(*data, device_, texture_too_);
        ScheduledStep scheduled;
        scheduled.view = view;
        result.loss += evaluator.loss(0, scheduled, *data, source_.name(view)) / count;
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
