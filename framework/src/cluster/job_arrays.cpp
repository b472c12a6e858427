#include "cluster/job_arrays.h"
#include "base/common.h"

#include <algorithm>
#include <optional>
#include <set>

namespace fresco::host
{
namespace
{

using ArrayId = std::pair<std::string, bool>;  ///< With whether it was queued before.

ArrayId array_of(const ElementPlace& place)
{
    return {place.array, place.queued_before};
}

/// A task of the group that is being placed.
struct Waiting
{
    const QueuedTask* task = nullptr;
    std::map<std::string, std::vector<ElementPlace>> needs;  ///< By group; what is done is left out.
};

/// What the elements of an array have in common.
struct Common
{
    JobLimits limits;
    std::map<ArrayId, std::set<std::size_t>> fixed;  ///< Elements that all of them wait for.
    std::optional<ArrayId> corresponding;

    friend auto operator<=>(const Common&, const Common&) = default;
};

/// Elements by index, or in their order where indices are free.
struct Cell
{
    std::vector<std::pair<std::size_t, const QueuedTask*>> elements;
    std::set<std::size_t> taken;
};

class Arranger
{
  public:
    Arranger(const std::map<std::size_t, ElementPlace>& queued, std::size_t largest) : places_(queued), largest_(largest) {}

    void add_group(const std::vector<const QueuedTask*>& tasks)
    {
        const std::vector<Waiting> waiting = each<Waiting>(tasks, [&](const QueuedTask* task) { return waiting_of(*task); });
        std::map<Common, std::vector<Cell>> best = cells(waiting, "");
        for (const std::string& group : groups_that_may_correspond(waiting))
            if (auto other = cells(waiting, group); count(other) < count(best))
                best = std::move(other);
        // In the order of their first tasks.
        std::vector<std::pair<const Common*, const Cell*>> ordered;
        for (const auto& [common, its_cells] : best)
            for (const Cell& cell : its_cells)
                ordered.emplace_back(&common, &cell);
        std::ranges::sort(ordered, [](const auto& a, const auto& b)
                          { return a.second->elements.front().second->number < b.second->elements.front().second->number; });
        for (const auto& [common, cell] : ordered)
            append(*common, *cell);
    }

    std::vector<JobArray> take() { return std::move(arrays_); }

  private:
    Waiting waiting_of(const QueuedTask& task) const
    {
        Waiting waiting{&task, {}};
        for (const std::size_t need : task.needs)
            if (const auto place = places_.find(need); place != places_.end())
            {
                const auto group = groups_.find(need);
                waiting.needs[group == groups_.end() ? place->second.array : group->second].push_back(place->second);
            }
        return waiting;
    }

    /// Groups of which every task needs at most one.
    static std::set<std::string> groups_that_may_correspond(const std::vector<Waiting>& waiting)
    {
        std::set<std::string> groups;
        std::set<std::string> refused;
        for (const Waiting& one : waiting)
            for (const auto& [group, places] : one.needs)
                (places.size() == 1 ? groups : refused).insert(group);
        for (const std::string& group : refused)
            groups.erase(group);
        return groups;
    }

    /// Sorts the tasks into arrays, where the needs of `corresponding` become dependencies between elements of one index.
    std::map<Common, std::vector<Cell>> cells(const std::vector<Waiting>& waiting, const std::string& corresponding) const
    {
        std::map<Common, std::vector<Cell>> result;
        for (const Waiting& one : waiting)
        {
            const QueuedTask& task = *one.task;
            Common common{task.limits, {}, {}};
            std::optional<std::size_t> index;
            for (const auto& [group, places] : one.needs)
                for (const ElementPlace& place : places)
                    if (group == corresponding)
                    {
                        common.corresponding = array_of(place);
                        index = place.index;
                    }
                    else
                        common.fixed[array_of(place)].insert(place.index);
            auto& its_cells = result[common];
            auto cell = std::ranges::find_if(its_cells, [&](const Cell& each)
                                             { return index ? !each.taken.contains(*index) : each.elements.size() < largest_; });
            if (cell == its_cells.end())
                cell = its_cells.insert(its_cells.end(), Cell{});
            const std::size_t at = index.value_or(cell->elements.size());
            cell->taken.insert(at);
            cell->elements.emplace_back(at, &task);
        }
        return result;
    }

    static std::size_t count(const std::map<Common, std::vector<Cell>>& cells)
    {
        std::size_t count = 0;
        for (const auto& [common, its_cells] : cells)
            count += its_cells.size();
        return count;
    }

    void append(const Common& common, const Cell& cell)
    {
        const std::string& group = cell.elements.front().second->group;
        JobArray array{group + "-" + std::to_string(arrays_of_[group]++), {}, {}, common.limits};
        for (const auto& [index, task] : cell.elements)
        {
            array.elements.push_back({index, task->number, task->name});
            places_[task->number] = {array.name, index, false};
            groups_[task->number] = group;
        }
        std::ranges::sort(array.elements, {}, &ArrayElement::index);
        sizes_[array.name] = array.elements.size();
        for (const auto& [other, elements] : common.fixed)
        {
            const bool whole = !other.second && sizes_.at(other.first) == elements.size();
            array.dependencies.push_back(
                {other.first, other.second, false,
                 whole ? std::vector<std::size_t>{} : std::vector<std::size_t>(elements.begin(), elements.end())});
        }
        if (common.corresponding)
            array.dependencies.push_back({common.corresponding->first, common.corresponding->second, true, {}});
        arrays_.push_back(std::move(array));
    }

    std::map<std::size_t, ElementPlace> places_;  ///< By task.
    std::map<std::size_t, std::string> groups_;   ///< Of the tasks placed here.
    std::map<std::string, std::size_t> sizes_;    ///< Of arrays.
    std::map<std::string, std::size_t> arrays_of_;
    std::size_t largest_;
    std::vector<JobArray> arrays_;
};

}  // namespace

std::vector<JobArray> job_arrays(const std::vector<QueuedTask>& tasks, const std::map<std::size_t, ElementPlace>& queued,
                                 std::size_t largest)
{
    Arranger arranger(queued, largest);
    for (auto begin = tasks.begin(); begin != tasks.end();)
    {
        std::vector<const QueuedTask*> group;
        for (const std::string name = begin->group; begin != tasks.end() && begin->group == name; ++begin)
            group.push_back(&*begin);
        arranger.add_group(group);
    }
    return arranger.take();
}

std::string index_ranges(const std::vector<ArrayElement>& elements)
{
    std::string text;
    for (std::size_t i = 0; i < elements.size();)
    {
        std::size_t end = i + 1;
        while (end < elements.size() && elements[end].index == elements[end - 1].index + 1)
            ++end;
        text += (text.empty() ? "" : ",") + std::to_string(elements[i].index);
        if (end - i > 1)
            text += "-" + std::to_string(elements[end - 1].index);
        i = end;
    }
    return text;
}

}  // namespace fresco::host
