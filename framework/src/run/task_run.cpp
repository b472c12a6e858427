#include "base/text.h"
#include "run/task_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{

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
