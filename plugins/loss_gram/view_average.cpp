#include "view_average.h"

#include <fresco/error.h>

#include <ATen/ATen.h>

#include <fmt/format.h>

namespace gram
{
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
