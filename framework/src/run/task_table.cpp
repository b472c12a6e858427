#include "run/task_table.h"
#include "base/text.h"
#include "pipeline/graph.h"
#include "pipeline/pipeline_options.h"

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <set>
#include <tuple>

namespace fresco::host
{
namespace
{

/// Until a stage's process is at work, and from its end to the next.
constexpr double start_seconds = 0.3;

/// Stages of one combination that run together.
struct Unit
{
    std::vector<std::string> labels;  ///< In the order of the group's axes.
    std::vector<std::size_t> stages;
    double seconds = 0;
    double memory_mb = 0;
    std::set<std::size_t> reads;  ///< Units of other groups.
    std::size_t task = 0;
};

/// The number of axes, the axes (by their numbers), and how often the stages before changed between processor and GPU: odd
/// numbers work on a GPU. In this order no group needs a later one.
using GroupKey = std::tuple<std::size_t, std::vector<std::size_t>, int>;

class TaskMaker
{
  public:
    TaskMaker(const Pipeline& pipeline, const std::vector<bool>& runs, const std::map<std::string, CostFigures>& estimates,
              const TaskSettings& settings)
        : pipeline_(pipeline), runs_(runs), estimates_(estimates), settings_(settings)
    {
    }

    TaskTable make()
    {
        list_axes();
        make_units();
        link_units();
        for (auto& [key, units] : groups_)
            make_group(key, units);
        table_.stage_axes = pipeline_.sweep.stage_axes;
        table_.task_count = table_.tasks.size();
        return std::move(table_);
    }

  private:
    void list_axes()
    {
        const Sweep& sweep = pipeline_.sweep;
        for (std::size_t axis = 0; axis < sweep.axes.size(); ++axis)
        {
            TaskAxis& listed = table_.axes.emplace_back(TaskAxis{sweep.axes[axis], {}});
            std::set<std::string> seen;
            for (const Combination& combination : sweep.combinations)
                if (seen.insert(combination.values[axis]).second)
                    listed.labels.push_back(combination.values[axis]);
        }
    }

    std::vector<std::size_t> axes_of(const PipelineStage& stage) const
    {
        std::vector<std::size_t> axes;
        const auto known = pipeline_.sweep.stage_axes.find(stage.own_name);
        for (std::size_t axis = 0; axis < table_.axes.size() && known != pipeline_.sweep.stage_axes.end(); ++axis)
            if (std::ranges::find(known->second, table_.axes[axis].name) != known->second.end())
                axes.push_back(axis);
        return axes;
    }

    /// How often stages of the same combination before this one changed between processor and GPU.
    int changes_before(std::size_t stage) const
    {
        const int parity = works_on_gpu(pipeline_.stages[stage]) ? 1 : 0;
        int changes = parity;
        for (const std::size_t producer : pipeline_.graph->needs(stage))
            if (runs_[producer] && pipeline_.stages[producer].place == pipeline_.stages[stage].place &&
                axes_.at(pipeline_.stages[producer].own_name) == axes_.at(pipeline_.stages[stage].own_name))
                changes = std::max(changes, changes_[producer]);
        return changes + (changes - parity) % 2;
    }

    void make_units()
    {
        const std::size_t count = pipeline_.stages.size();
        changes_.resize(count);
        unit_of_.resize(count);
        std::map<std::tuple<std::vector<std::size_t>, std::string, int>, std::size_t> known;
        for (std::size_t i = 0; i < count; ++i)
        {
            const PipelineStage& stage = pipeline_.stages[i];
            if (!runs_[i])
                continue;
            if (!axes_.contains(stage.own_name))
                axes_[stage.own_name] = axes_of(stage);
            const std::vector<std::size_t>& axes = axes_.at(stage.own_name);
            changes_[i] = changes_before(i);
            const auto [unit, fresh] = known.try_emplace({axes, stage.place, changes_[i]}, units_.size());
            if (fresh)
            {
                groups_[{axes.size(), axes, changes_[i]}].push_back(unit->second);
                units_.push_back({split(stage.place, ','), {}, 0, 0, {}, 0});
            }
            unit_of_[i] = unit->second;
            Unit& own = units_[unit->second];
            own.stages.push_back(i);
            const auto cost = estimates_.find(stage.name);
            own.seconds += start_seconds + (cost == estimates_.end() ? 0 : cost->second.seconds);
            own.memory_mb = std::max(own.memory_mb, cost == estimates_.end() ? 0 : cost->second.memory_mb);
        }
    }

    void link_units()
    {
        for (std::size_t i = 0; i < runs_.size(); ++i)
            if (runs_[i])
                for (const std::size_t producer : pipeline_.graph->needs(i))
                    if (runs_[producer] && unit_of_[producer] != unit_of_[i])
                        units_[unit_of_[i]].reads.insert(unit_of_[producer]);
    }

    std::set<std::size_t> needs_of(const Unit& unit) const
    {
        std::set<std::size_t> tasks;
        for (const std::size_t read : unit.reads)
            tasks.insert(units_[read].task);
        return tasks;
    }

    void make_group(const GroupKey& key, const std::vector<std::size_t>& units)
    {
        const auto& [axis_count, axes, changes] = key;
        TaskGroup group;
        std::string& name = group.name;
        for (const std::size_t axis : axes)
        {
            group.axes.push_back(table_.axes[axis].name);
            name += (name.empty() ? "" : ",") + table_.axes[axis].name;
        }
        group.gpu = changes % 2 == 1;
        name += std::string(axes.empty() ? "once" : "") + (group.gpu ? "-gpu" : "") +
                (changes > 1 ? "-" + std::to_string(changes / 2 + 1) : "");
        group.first = table_.tasks.size();
        group.threads = settings_.threads;
        pack(group, units);
        describe(group, units);
        table_.groups.push_back(std::move(group));
    }

    /// Of units with the same value of the leading axis at a time, which are neighbors.
    void pack(const TaskGroup& group, const std::vector<std::size_t>& units)
    {
        for (std::size_t begin = 0; begin < units.size();)
        {
            std::size_t end = begin;
            double seconds = 0;
            std::optional<std::set<std::size_t>> needs = needs_of(units_[units[begin]]);
            for (; end < units.size() && same_leading_value(units[begin], units[end]); ++end)
            {
                seconds += units_[units[end]].seconds;
                if (needs && needs_of(units_[units[end]]) != *needs)
                    needs.reset();
            }
            const bool is_open = table_.tasks.size() > group.first;
            const bool joins = is_open && needs && *needs == open_needs_ && open_seconds() + seconds <= settings_.pack_seconds;
            for (std::size_t i = begin; i < end; ++i)
            {
                const bool first = i == begin ? !joins : open_seconds() + units_[units[i]].seconds > settings_.pack_seconds;
                add(group, units[i], first);
            }
            begin = end;
        }
    }

    bool same_leading_value(std::size_t a, std::size_t b) const
    {
        return units_[a].labels.empty() || units_[a].labels.front() == units_[b].labels.front();
    }

    double open_seconds() const { return table_.tasks.back().seconds; }

    /// To the task that was begun last, or to a new one.
    void add(const TaskGroup& group, std::size_t number, bool begins_task)
    {
        Unit& unit = units_[number];
        if (begins_task)
        {
            table_.tasks.push_back({table_.tasks.size(), table_.groups.size(), {}, {}, {}, 0, 0});
            open_needs_.clear();
            for (std::size_t i = 0; i < group.axes.size(); ++i)
                table_.tasks.back().axes.emplace_back(group.axes[i], unit.labels[i]);
        }
        Task& task = table_.tasks.back();
        unit.task = task.id;
        for (const std::size_t stage : unit.stages)
            task.stages.push_back(pipeline_.stages[stage].name);
        const auto is_other = [&](const auto& axis) {
            return unit.labels[static_cast<std::size_t>(std::ranges::find(group.axes, axis.first) - group.axes.begin())] !=
                   axis.second;
        };
        std::erase_if(task.axes, is_other);
        open_needs_.merge(needs_of(unit));
        task.needs.assign(open_needs_.begin(), open_needs_.end());
        task.seconds += unit.seconds;
        task.memory_mb = std::max(task.memory_mb, unit.memory_mb);
    }

    void describe(TaskGroup& group, const std::vector<std::size_t>& units) const
    {
        group.count = table_.tasks.size() - group.first;
        std::set<std::size_t> needs;
        for (std::size_t i = group.first; i < table_.tasks.size(); ++i)
        {
            const Task& task = table_.tasks[i];
            for (const std::size_t need : task.needs)
                needs.insert(table_.tasks[need].group);
            group.seconds = std::max(group.seconds, task.seconds);
            group.memory_mb = std::max(group.memory_mb, task.memory_mb);
        }
        group.needs.assign(needs.begin(), needs.end());
        std::set<std::string> stages;
        for (const std::size_t unit : units)
            for (const std::size_t stage : units_[unit].stages)
                if (stages.insert(pipeline_.stages[stage].own_name).second)
                    group.stages.push_back(pipeline_.stages[stage].own_name);
    }

    const Pipeline& pipeline_;
    const std::vector<bool>& runs_;
    const std::map<std::string, CostFigures>& estimates_;
    const TaskSettings& settings_;
    TaskTable table_;
    std::map<std::string, std::vector<std::size_t>> axes_;  ///< By a stage's own name.
    std::vector<int> changes_;                              ///< Per stage.
    std::vector<std::size_t> unit_of_;                      ///< Per stage.
    std::vector<Unit> units_;
    std::map<GroupKey, std::vector<std::size_t>> groups_;
    std::set<std::size_t> open_needs_;
};

/// "kitchen,waves" of "texture@kitchen,waves".
std::string place_of(const std::string& stage)
{
    const std::size_t at = stage.find('@');
    return at == std::string::npos ? "" : stage.substr(at + 1);
}

/// The label of each axis.
std::map<std::string, std::string> combination(const std::vector<std::string>& axes, const std::string& place)
{
    std::map<std::string, std::string> labels;
    const std::vector<std::string> values = split(place, ',');
    for (std::size_t axis = 0; axis < axes.size(); ++axis)
        labels[axes[axis]] = axis < values.size() ? values[axis] : "";
    return labels;
}

/// "atlas (data=kitchen)"
std::string shown(const PipelineStage& stage, const TaskTable& head)
{
    const auto axes = head.stage_axes.find(stage.own_name);
    if (axes == head.stage_axes.end())
        return stage.own_name;
    const auto labels = combination(axes->second, stage.place);
    std::string text;
    for (const std::string& axis : axes->second)
    {
        // The label of a number says its axis already.
        const std::string& label = labels.at(axis);
        text += (text.empty() ? "" : ", ") + (label.starts_with(axis + "=") ? label : axis + "=" + label);
    }
    return stage.own_name + " (" + text + ")";
}

}  // namespace

TaskTable make_task_table(const Pipeline& pipeline, const std::vector<bool>& runs,
                          const std::map<std::string, CostFigures>& estimates, const TaskSettings& settings)
{
    return TaskMaker(pipeline, runs, estimates, settings).make();
}

PipelineRequest task_request(const TaskTable& head, const Task& task)
{
    PipelineRequest request = head.pipeline;
    request.until.clear();
    SweepPart& part = request.part.emplace();
    part.stage_axes = head.stage_axes;
    std::set<std::string> seen;
    for (const std::string& stage : task.stages)
        if (seen.insert(place_of(stage)).second)
            part.combinations.push_back(combination(head.groups.at(task.group).axes, place_of(stage)));
    return request;
}

std::string changed_plugin(const TaskTable& head, const Pipeline& pipeline)
{
    for (const PipelineStage& stage : pipeline.stages)
    {
        std::vector<const TypeDescription*> types = stage.components;
        types.push_back(stage.type);
        for (const TypeDescription* type : types)
        {
            const auto frozen = head.plugins.find(type->type);
            if (frozen == head.plugins.end() || frozen->second.hash != type->library_hash)
                return fmt::format(
                    "the plugin of {}, {}, is not the one that the tasks were made with{}: make the tasks again, or "
                    "use that plugin",
                    type->type, type->library.string(),
                    frozen == head.plugins.end() || frozen->second.library == type->library
                        ? ""
                        : " (" + frozen->second.library.string() + ")");
        }
    }
    return "";
}

RunPart task_part(const std::filesystem::path& folder, const TaskTable& head, const Task& task)
{
    std::map<std::string, std::size_t> makers;
    for (const std::size_t need : task.needs)
        for (const std::string& stage : read_task(folder, head, need).stages)
            makers[stage] = need;
    RunPart part;
    part.stages.insert(task.stages.begin(), task.stages.end());
    part.missing_text = [&head, id = task.id, makers = std::move(makers)](const PipelineStage& stage)
    {
        const auto maker = makers.find(stage.name);
        return fmt::format("task {} needs {}, which {}", id, shown(stage, head),
                           maker == makers.end() ? "was stored when the tasks were made and is gone: make the tasks again"
                                                 : fmt::format("task {} makes: run it first", maker->second));
    };
    return part;
}

}  // namespace fresco::host
