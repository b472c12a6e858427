#include "store/statistics.h"
#include "base/records.h"
#include <fresco/error.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

constexpr std::size_t kept_runs = 8;

Journal journal_of(const Store& store)
{
    return Journal(store.root() / "stats.jsonl");
}

bool is_figures(const Value* value)
{
    return value != nullptr && value->is_list() && value->as_list().size() == 3 &&
           std::ranges::all_of(value->as_list(), [](const Value& figure) { return figure.is_number(); });
}

std::map<std::string, std::vector<Value>> last_runs(const Store& store)
{
    std::map<std::string, std::vector<Value>> runs;
    for (Value& run : journal_of(store).read())
    {
        const Value* type = run.find("type");
        if (type == nullptr || !type->is_string() || !is_figures(run.find("measured")) || !is_figures(run.find("estimated")))
            continue;  // Of another journal, or written by another version of fresco.
        auto& of_type = runs[type->as_string()];
        of_type.push_back(std::move(run));
        if (of_type.size() > kept_runs)
            of_type.erase(of_type.begin());
    }
    return runs;
}

Value figures(const CostFigures& cost)
{
    return Value::List{cost.seconds, cost.memory_mb, cost.disk_mb};
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

/// One of the three figures, corrected by all remembered runs.
double corrected_figure(const std::vector<Value>& runs, std::size_t which, double estimated)
{
    std::vector<double> ratios;
    std::vector<double> measured;
    for (const Value& run : runs)
    {
        const double said = run.at("estimated").as_list().at(which).as_double();
        const double took = run.at("measured").as_list().at(which).as_double();
        measured.push_back(took);
        if (said > 0)
            ratios.push_back(took / said);
    }
    if (estimated > 0 && !ratios.empty())
        return estimated * median(ratios);
    return measured.empty() || estimated > 0 ? estimated : median(measured);
}

}  // namespace

void record_cost(const Store& store, const std::string& type, const CostFigures& measured, const CostFigures& estimated)
{
    journal_of(store).add(Value::Map{{"type", type}, {"measured", figures(measured)}, {"estimated", figures(estimated)}});
}

void tidy_costs(const Store& store)
{
    std::vector<Value> all;
    for (auto& [type, runs] : last_runs(store))
        for (Value& run : runs)
        {
            run.as_map().pop_back();  // Its checksum.
            all.push_back(std::move(run));
        }
    journal_of(store).replace(all);
}

Statistics::Statistics(const Store& store) : runs_(last_runs(store)) {}

bool Statistics::knows(const std::string& type) const
{
    return runs_.contains(type);
}

CostFigures Statistics::corrected(const std::string& type, const CostFigures& estimated) const
{
    const auto runs = runs_.find(type);
    if (runs == runs_.end())
        return estimated;
    return {corrected_figure(runs->second, 0, estimated.seconds), corrected_figure(runs->second, 1, estimated.memory_mb),
            corrected_figure(runs->second, 2, estimated.disk_mb)};
}

}  // namespace fresco::host
