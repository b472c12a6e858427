#include "run/tasks.h"
#include "base/common.h"
#include "pipeline/graph.h"
#include "pipeline/pipeline_options.h"
#include "run/stage_choice.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>
#include <tuple>

namespace fresco::host
{
namespace
{

class TaskMaker
{
  public:
    TaskMaker(const Pipeline& pipeline, const std::string& until)
        : pipeline_(pipeline), switches_(pipeline.stages.size()), task_of_(pipeline.stages.size())
    {
        const auto is_end = [&](const PipelineStage& stage) { return until.empty() || stage.own_name == until; };
        selected_ = with_needed(pipeline, each<bool>(pipeline.stages, is_end));
    }

    std::vector<Task> make()
    {
        for (std::size_t i = 0; i < pipeline_.stages.size(); ++i)
            if (selected_[i])
                add(i);
        for (std::size_t i = 0; i < pipeline_.stages.size(); ++i)
            for (const std::size_t producer : pipeline_.graph->needs(i))
                if (selected_[i] && task_of_[producer] != task_of_[i])
                    needs_[task_of_[i]].insert(tasks_[task_of_[producer]].name);
        for (const auto& [task, names] : needs_)
            tasks_[task].needs.assign(names.begin(), names.end());
        std::vector<Task> sorted;
        for (const auto& [key, task] : by_key_)
            sorted.push_back(std::move(tasks_[task]));
        return sorted;
    }

  private:
    /// Axis count first: in this order no task needs a later one.
    using Key = std::tuple<std::size_t, std::vector<std::string>, int, std::string>;

    std::vector<std::string> axes_of(const PipelineStage& stage) const
    {
        const auto known = pipeline_.sweep.stage_axes.find(stage.own_name);
        return known == pipeline_.sweep.stage_axes.end() ? std::vector<std::string>{} : known->second;
    }

    /// How often the stages before this one, for the same axes, switch between processor and GPU; odd on a GPU.
    int switches_before(std::size_t number) const
    {
        const PipelineStage& stage = pipeline_.stages[number];
        const int parity = works_on_gpu(stage) ? 1 : 0;
        int switches = parity;
        for (const std::size_t producer : pipeline_.graph->needs(number))
            if (pipeline_.stages[producer].place == stage.place && axes_of(pipeline_.stages[producer]) == axes_of(stage))
                switches = std::max(switches, switches_[producer]);
        return switches + (switches - parity) % 2;
    }

    void add(std::size_t number)
    {
        const PipelineStage& stage = pipeline_.stages[number];
        const std::vector<std::string> axes = axes_of(stage);
        const int switches = switches_[number] = switches_before(number);
        const auto [known, fresh] = by_key_.try_emplace(Key{axes.size(), axes, switches, stage.place}, tasks_.size());
        task_of_[number] = known->second;
        if (fresh)
        {
            const std::string group =
                fmt::format("{}{}{}", axes.empty() ? "once" : fmt::format("{}", fmt::join(axes, ",")),
                            switches % 2 == 1 ? "-gpu" : "", switches > 1 ? "-" + std::to_string(switches / 2 + 1) : "");
            tasks_.push_back({group + (stage.place.empty() ? "" : "@" + stage.place), {}, {}, switches % 2 == 1});
        }
        tasks_[known->second].stages.push_back(stage.name);
    }

    const Pipeline& pipeline_;
    std::vector<bool> selected_;
    std::vector<int> switches_;         ///< By stage.
    std::vector<std::size_t> task_of_;  ///< By stage.
    std::vector<Task> tasks_;
    std::map<Key, std::size_t> by_key_;
    std::map<std::size_t, std::set<std::string>> needs_;
};

/// `--set` arguments for what `device: auto` stands for on this machine: the machines that run the tasks may have others.
std::vector<std::pair<std::string, std::string>> settled_devices(const Pipeline& pipeline)
{
    // Only where all stages of one name have the same, so that a device that depends on an axis is not touched.
    std::map<std::string, std::set<std::pair<std::string, std::string>>> devices;
    for (const PipelineStage& stage : pipeline.stages)
    {
        const std::string option = device_option(*stage.type);
        const Value* device = option.empty() ? nullptr : stage.options->find(option);
        const bool is_named = device && device->is_string();
        devices[stage.own_name].emplace(is_named ? stage.own_name + "." + option : "", is_named ? device->as_string() : "");
    }
    std::vector<std::pair<std::string, std::string>> sets;
    for (const auto& [stage, found] : devices)
        if (found.size() == 1 && !found.begin()->first.empty())
            sets.push_back(*found.begin());
    return sets;
}

}  // namespace

std::vector<Task> tasks_of(const Pipeline& pipeline, const std::string& until)
{
    return TaskMaker(pipeline, until).make();
}

RunPart task_part(const Pipeline& pipeline, const std::string& until, const std::string& name)
{
    const std::vector<Task> tasks = tasks_of(pipeline, until);
    const auto task = std::ranges::find(tasks, name, &Task::name);
    if (task == tasks.end())
        throw Error(fmt::format("--task {}: unknown task{}; 'fresco plan FILE --tasks' lists them", name,
                                suggestion(name, each(tasks, &Task::name))));
    std::map<std::string, std::string> makers;
    for (const Task& other : tasks)
        for (const std::string& stage : other.stages)
            makers[stage] = other.name;
    RunPart part;
    part.stages.insert(task->stages.begin(), task->stages.end());
    part.missing_text = [name, makers = std::move(makers)](const PipelineStage& stage)
    { return fmt::format("task {} needs the result of {}: run task {} first", name, stage.name, makers.at(stage.name)); };
    return part;
}

Value plan_tasks(const Pipeline& pipeline, const std::string& until, const Store& store, int threads)
{
    FileHashes hashes(store.file_index());
    RunState state(pipeline, store, hashes, until);
    state.update();
    hashes.save();
    Expectations expected(store);
    std::map<std::string, const StageNode*> nodes;
    for (const StageNode& node : state.nodes())
        nodes[node.stage->name] = &node;
    Value::List tasks;
    for (const Task& task : tasks_of(pipeline, until))
    {
        bool done = true;
        std::optional<double> seconds = 0;
        std::optional<double> memory_mb = 0;
        for (const std::string& name : task.stages)
        {
            const StageNode& node = *nodes.at(name);
            if (node.state == StageState::failed)
                throw MissingInput("stage " + name + ": " + node.error);
            done = done && node.state != StageState::waiting;
            const auto usage = expected.measured(node);
            const auto memory = expected.memory_mb(node);
            seconds = seconds && usage ? std::optional(*seconds + usage->seconds) : std::nullopt;
            memory_mb = memory_mb && memory ? std::optional(std::max(*memory_mb, *memory)) : std::nullopt;
        }
        tasks.push_back(Value::Map{{"name", task.name},
                                   {"stages", Value::List(task.stages.begin(), task.stages.end())},
                                   {"needs", Value::List(task.needs.begin(), task.needs.end())},
                                   {"gpu", task.gpu},
                                   {"done", done},
                                   {"threads", threads},
                                   {"minutes", seconds ? Value(std::ceil(*seconds / 60)) : Value()},
                                   {"mem_mb", memory_mb ? Value(std::ceil(*memory_mb)) : Value()}});
    }
    Value::List args;
    for (const auto& [option, device] : settled_devices(pipeline))
    {
        args.emplace_back("--set");
        args.emplace_back(option + "=" + device);
    }
    return Value::Map{{"args", std::move(args)}, {"tasks", std::move(tasks)}};
}

}  // namespace fresco::host
