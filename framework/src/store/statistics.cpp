#include "store/statistics.h"
#include "base/durable_file.h"
#include <fresco/error.h>

#include <algorithm>
#include <vector>

namespace fresco::host
{
namespace
{

constexpr std::size_t kept_runs = 8;

std::filesystem::path statistics_file(const Store& store)
{
    return store.root() / "stats.json";
}

Value read_statistics(const Store& store)
{
    try
    {
        return read_record(statistics_file(store)).at("types");
    }
    catch (const Error&)
    {
        return Value::Map{};
    }
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
double corrected_figure(const Value& runs, std::size_t which, double estimated)
{
    std::vector<double> ratios;
    std::vector<double> measured;
    for (const auto& run : runs.as_list())
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
    Value all = read_statistics(store);
    Value::List runs;
    if (const Value* known = all.find(type); known != nullptr && known->is_list())
        runs = known->as_list();
    runs.insert(runs.begin(), Value(Value::Map{{"measured", figures(measured)}, {"estimated", figures(estimated)}}));
    if (runs.size() > kept_runs)
        runs.resize(kept_runs);
    all.set(type, std::move(runs));
    write_record(statistics_file(store), Value::Map{{"types", std::move(all)}});
}

Statistics::Statistics(const Store& store) : entries_(read_statistics(store)) {}

bool Statistics::knows(const std::string& type) const
{
    return entries_.find(type) != nullptr;
}

CostFigures Statistics::corrected(const std::string& type, const CostFigures& estimated) const
{
    const Value* runs = entries_.find(type);
    if (runs == nullptr)
        return estimated;
    try
    {
        return {corrected_figure(*runs, 0, estimated.seconds), corrected_figure(*runs, 1, estimated.memory_mb),
                corrected_figure(*runs, 2, estimated.disk_mb)};
    }
    catch (const std::exception&)
    {
        return estimated;  // A damaged record of costs must not fail the plan.
    }
}

}  // namespace fresco::host
