#include "balance.h"

#include <algorithm>
#include <sstream>

namespace fresco::optimize
{

std::optional<double> style_over_content(const std::map<std::string, std::shared_ptr<Loss>>& losses,
                                         const std::map<std::string, double>& summands)
{
    double style = 0;
    double content = 0;
    for (const auto& [name, loss] : losses)
    {
        const auto needs = loss->needs().features;
        const auto found = summands.find(name);
        if (needs.empty() || found == summands.end())
            continue;
        const bool sees_camera = std::any_of(needs.begin(), needs.end(), [](const LossNeeds::Layers& l) { return l.camera; });
        (sees_camera ? content : style) += found->second;
    }
    return style > 0 && content > 0 ? std::optional(style / content) : std::nullopt;
}

void report_balance(const std::map<std::string, std::shared_ptr<Loss>>& losses, const std::map<std::string, double>& summands,
                    bool begins_empty, RunContext& run)
{
    const auto ratio = style_over_content(losses, summands);
    if (!ratio)
        return;
    run.report("initial_style_over_content", *ratio);
    if (!begins_empty || (*ratio >= 0.3 && *ratio <= 8))
        return;
    std::ostringstream text;
    text.precision(3);
    text << "at the first step style counts " << *ratio << " times as much as content, where 0.3 to 8 is usual: the texture will "
         << "show little of the " << (*ratio < 1 ? "style" : "room")
         << "; does the scale of the network's weights (fresco weights inspect) fit the losses' weights?";
    run.warning(text.str());
}

}  // namespace fresco::optimize
