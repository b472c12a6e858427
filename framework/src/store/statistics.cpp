#include "store/statistics.h"
#include "base/common.h"
#include <fresco/error.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

constexpr std::ptrdiff_t kept_with_options = 8;
constexpr std::size_t kept_of_type = 64;

Value entry_of(const StageKind& stage, const Usage& took)
{
    return Value::Map{{"type", stage.type}, {"options", stage.options}, {"seconds", took.seconds}, {"memory_mb", took.memory_mb}};
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace

Statistics::Statistics(const Store& store) : journal_(store.root() / "stats.jsonl")
{
    for (const Value& run : journal_.read())
        // A line that lacks an entry was written by another version of fresco.
        attempt(
            [&]
            {
                keep({run.at("type").as_string(), run.at("options").as_string()},
                     {run.at("seconds").as_double(), run.at("memory_mb").as_double(), 0});
            });
}

void Statistics::keep(const StageKind& stage, const Usage& took)
{
    std::vector<Run>& of_type = runs_[stage.type];
    of_type.push_back({stage.options, took});
    const auto is_same = [&](const Run& run) { return run.options == stage.options; };
    if (std::ranges::count_if(of_type, is_same) > kept_with_options)
        of_type.erase(std::ranges::find_if(of_type, is_same));
    if (of_type.size() > kept_of_type)
        of_type.erase(of_type.begin());
}

void Statistics::add(const StageKind& stage, const Usage& took)
{
    keep(stage, took);
    journal_.add(entry_of(stage, took));
}

void Statistics::tidy() const
{
    std::vector<Value> all;
    for (const auto& [type, runs] : runs_)
        for (const Run& run : runs)
            all.push_back(entry_of({type, run.options}, run.took));
    journal_.replace(all);
}

std::optional<Usage> Statistics::last(const StageKind& stage) const
{
    const std::optional<Usage> usage = last_of(stage.type, &stage.options);
    return usage ? usage : last_of(stage.type, nullptr);
}

std::optional<Usage> Statistics::last_with_options(const StageKind& stage) const
{
    return last_of(stage.type, &stage.options);
}

std::optional<Usage> Statistics::last_of(const std::string& type, const std::string* options) const
{
    const auto found = runs_.find(type);
    if (found == runs_.end())
        return std::nullopt;
    std::vector<double> seconds;
    double memory_mb = 0;
    for (const Run& run : found->second)
        if (options == nullptr || run.options == *options)
        {
            seconds.push_back(run.took.seconds);
            memory_mb = std::max(memory_mb, run.took.memory_mb);
        }
    return seconds.empty() ? std::nullopt : std::optional(Usage{median(seconds), memory_mb, 0});
}

}  // namespace fresco::host
