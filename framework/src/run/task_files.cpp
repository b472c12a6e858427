#include "base/common.h"
#include "base/machine.h"
#include "base/records.h"
#include "run/task_table.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::host
{
namespace
{

using Map = Value::Map;
using List = Value::List;

constexpr int table_version = 1;
/// Of a chunk; what is larger was not written by this program.
constexpr std::size_t size_limit = std::size_t{1} << 30U;

fs::path head_file(const fs::path& folder)
{
    return folder / "tasks.json";
}

fs::path chunk_file(const fs::path& folder, std::size_t chunk)
{
    return folder / "tasks" / fmt::format("{:06}.json", chunk);
}

std::string copy_name(std::size_t number, const fs::path& file)
{
    return fmt::format("pipeline/{}-{}", number, file.filename().string());
}

/// Of texts or numbers.
template <class Item>
Value list_value(const std::vector<Item>& items)
{
    return List(items.begin(), items.end());
}

Value task_value(const Task& task)
{
    Map axes;
    for (const auto& [axis, label] : task.axes)
        axes.emplace_back(axis, label);
    return Map{{"id", task.id},
               {"group", task.group},
               {"axes", std::move(axes)},
               {"stages", list_value(task.stages)},
               {"needs", list_value(task.needs)},
               {"seconds", task.seconds},
               {"memory_mb", task.memory_mb}};
}

Value group_value(const TaskGroup& group)
{
    return Map{{"name", group.name},
               {"axes", list_value(group.axes)},
               {"gpu", group.gpu},
               {"stages", list_value(group.stages)},
               {"needs", list_value(group.needs)},
               {"first", group.first},
               {"count", group.count},
               {"seconds", group.seconds},
               {"memory_mb", group.memory_mb},
               {"threads", group.threads}};
}

Value pipeline_value(const PipelineRequest& pipeline)
{
    List files;
    for (std::size_t i = 0; i < pipeline.texts.size(); ++i)
        files.push_back(Map{{"file", pipeline.texts[i].file.string()},
                            {"copy", copy_name(i, pipeline.texts[i].file)},
                            {"hash", content_hash(pipeline.texts[i].text)}});
    const auto set_value = [](const auto& set) { return Map{{"name", set.first}, {"value", set.second}}; };
    return Map{{"file", pipeline.file.string()},
               {"working_directory", pipeline.working_directory.string()},
               {"until", pipeline.until},
               {"preview", pipeline.preview},
               {"files", std::move(files)},
               {"sets", each<Value>(pipeline.sets, set_value)},
               {"without", list_value(pipeline.without)}};
}

Value head_value(const TaskTable& table)
{
    Map plugins;
    for (const auto& [type, plugin] : table.plugins)
        plugins.emplace_back(type, Map{{"library", plugin.library.string()}, {"hash", plugin.hash}});
    const auto axis_value = [](const TaskAxis& axis) { return Map{{"name", axis.name}, {"labels", list_value(axis.labels)}}; };
    Map stage_axes;
    for (const auto& [stage, names] : table.stage_axes)
        stage_axes.emplace_back(stage, list_value(names));
    return Map{{"version", table_version},
               {"fresco", program_version()},
               {"pipeline", pipeline_value(table.pipeline)},
               {"plugins", std::move(plugins)},
               {"store", table.store.string()},
               {"out", table.out.string()},
               {"axes", each<Value>(table.axes, axis_value)},
               {"stage_axes", std::move(stage_axes)},
               {"groups", each<Value>(table.groups, group_value)},
               {"task_count", table.task_count},
               {"chunk_size", table.chunk_size}};
}

/// JsonPlace::integer for sizes.
std::size_t size_in(const JsonPlace& place, std::size_t least, std::size_t most)
{
    return static_cast<std::size_t>(place.integer(static_cast<std::int64_t>(least), static_cast<std::int64_t>(most)));
}

/// Ascending, below `end`.
std::vector<std::size_t> ascending(const JsonPlace& list, std::size_t end)
{
    std::vector<std::size_t> result;
    for (const JsonPlace& place : list.list())
    {
        const std::size_t least = result.empty() ? 0 : result.back() + 1;
        if (least >= end)
            place.fail(fmt::format("expected ascending numbers below {}", end));
        result.push_back(size_in(place, least, end - 1));
    }
    return result;
}

PipelineRequest read_pipeline(const JsonPlace& place, const fs::path& folder)
{
    place.has_only({"file", "working_directory", "until", "preview", "files", "sets", "without"});
    PipelineRequest pipeline;
    pipeline.file = place["file"].text();
    pipeline.working_directory = place["working_directory"].text();
    pipeline.until = place["until"].text();
    pipeline.preview = place["preview"].flag();
    pipeline.without = place["without"].texts();
    for (const JsonPlace& file : place["files"].list())
    {
        file.has_only({"file", "copy", "hash"});
        const fs::path copy = folder / file["copy"].text();
        pipeline.texts.push_back({file["file"].text(), read_text_file(copy)});
        if (content_hash(pipeline.texts.back().text) != file["hash"].text())
            throw Error(copy.string() + ": was edited; change " + pipeline.texts.back().file.string() +
                        " and make the tasks again");
    }
    if (pipeline.texts.empty() || pipeline.texts.front().file != pipeline.file)
        place.fail("files", "expected " + pipeline.file.string() + " first");
    for (const JsonPlace& set : place["sets"].list())
    {
        set.has_only({"name", "value"});
        pipeline.sets.emplace_back(set["name"].text(), set["value"].text());
    }
    return pipeline;
}

TaskGroup read_group(const JsonPlace& place, const TaskTable& table)
{
    place.has_only({"name", "axes", "gpu", "stages", "needs", "first", "count", "seconds", "memory_mb", "threads"});
    constexpr std::size_t most_threads = 1U << 16U;
    const std::size_t first = table.groups.empty() ? 0 : table.groups.back().first + table.groups.back().count;
    TaskGroup group;
    group.name = place["name"].text();
    group.axes = place["axes"].texts();
    group.gpu = place["gpu"].flag();
    group.stages = place["stages"].texts();
    group.needs = ascending(place["needs"], table.groups.size());
    group.first = size_in(place["first"], first, first);
    if (first >= table.task_count)
        place.fail("first", fmt::format("expected a number below the {} tasks", table.task_count));
    group.count = size_in(place["count"], 1, table.task_count - first);
    group.seconds = place["seconds"].amount();
    group.memory_mb = place["memory_mb"].amount();
    group.threads = static_cast<int>(size_in(place["threads"], 1, most_threads));
    return group;
}

Task read_task_entry(const JsonPlace& place, const TaskTable& head, std::size_t id)
{
    place.has_only({"id", "group", "axes", "stages", "needs", "seconds", "memory_mb"});
    Task task;
    task.id = size_in(place["id"], id, id);
    const auto owner = std::ranges::find_if(head.groups, [&](const TaskGroup& group) { return id - group.first < group.count; });
    const auto number = static_cast<std::size_t>(owner - head.groups.begin());
    task.group = size_in(place["group"], number, number);
    for (const auto& [axis, label] : place["axes"].map())
        task.axes.emplace_back(axis, label.text());
    task.stages = place["stages"].texts();
    if (task.stages.empty())
        place.fail("stages", "expected at least one stage");
    task.needs = ascending(place["needs"], id);
    task.seconds = place["seconds"].amount();
    task.memory_mb = place["memory_mb"].amount();
    return task;
}

std::vector<Task> read_chunk(const fs::path& folder, const TaskTable& head, std::size_t chunk)
{
    const fs::path file = chunk_file(folder, chunk);
    const Value value = parse_json(read_text_file(file, size_limit), file.string());
    const JsonPlace place(value, file.string());
    const std::vector<JsonPlace> entries = place["tasks"].list();
    place.has_only({"tasks"});
    const std::size_t first = chunk * head.chunk_size;
    const std::size_t count = std::min(head.chunk_size, head.task_count - first);
    if (entries.size() != count)
        place.fail("tasks", fmt::format("expected {} tasks, got {}", count, entries.size()));
    std::vector<Task> tasks;
    for (std::size_t i = 0; i < count; ++i)
        tasks.push_back(read_task_entry(entries[i], head, first + i));
    return tasks;
}

}  // namespace

Value to_value(const TaskTable& table)
{
    Value value = head_value(table);
    value.set("tasks", each<Value>(table.tasks, task_value));
    return value;
}

void write_task_table(const TaskTable& table, const fs::path& folder)
{
    if (path_status(head_file(folder)))
        throw Error(folder.string() + ": already holds tasks: choose another folder, or remove it");
    make_folder(folder / "pipeline");
    make_folder(folder / "tasks");
    for (std::size_t i = 0; i < table.pipeline.texts.size(); ++i)
        write_durable_file(folder / copy_name(i, table.pipeline.texts[i].file), table.pipeline.texts[i].text);
    for (std::size_t first = 0; first < table.tasks.size(); first += table.chunk_size)
    {
        std::string text = "{\"tasks\": [";
        for (std::size_t i = first; i < std::min(first + table.chunk_size, table.tasks.size()); ++i)
            text += (i == first ? "\n" : ",\n") + to_json(task_value(table.tasks[i]));
        write_durable_file(chunk_file(folder, first / table.chunk_size), text + "\n]}\n");
    }
    write_durable_file(head_file(folder), to_json(head_value(table), 2) + "\n");
}

TaskTable read_task_head(const fs::path& folder)
{
    const fs::path file = head_file(folder);
    if (!path_status(file))
        throw MissingInput(folder.string() + ": holds no tasks: 'fresco plan FILE --tasks --folder " + folder.string() +
                           "' makes them");
    const Value value = parse_json(read_text_file(file, size_limit), file.string());
    const JsonPlace place(value, file.string());
    size_in(place["version"], table_version, table_version);
    place.has_only(
        {"version", "fresco", "pipeline", "plugins", "store", "out", "axes", "stage_axes", "groups", "task_count", "chunk_size"});
    place["fresco"].text();
    constexpr std::size_t most_tasks = std::size_t{1} << 32U;
    TaskTable table;
    table.pipeline = read_pipeline(place["pipeline"], folder);
    for (const auto& [type, plugin] : place["plugins"].map())
    {
        plugin.has_only({"library", "hash"});
        table.plugins[type] = {plugin["library"].text(), plugin["hash"].text()};
    }
    table.store = place["store"].text();
    table.out = place["out"].text();
    for (const JsonPlace& axis : place["axes"].list())
    {
        axis.has_only({"name", "labels"});
        table.axes.push_back({axis["name"].text(), axis["labels"].texts()});
    }
    for (const auto& [stage, axes] : place["stage_axes"].map())
        table.stage_axes[stage] = axes.texts();
    table.task_count = size_in(place["task_count"], 0, most_tasks);
    table.chunk_size = size_in(place["chunk_size"], 1, most_tasks);
    for (const JsonPlace& group : place["groups"].list())
        table.groups.push_back(read_group(group, table));
    const std::size_t count = table.groups.empty() ? 0 : table.groups.back().first + table.groups.back().count;
    if (count != table.task_count)
        place.fail("groups", fmt::format("they have {} tasks, expected {}", count, table.task_count));
    return table;
}

Task read_task(const fs::path& folder, const TaskTable& head, std::size_t id)
{
    if (id >= head.task_count)
        throw Error(head_file(folder).string() + ": " +
                    (head.task_count == 0 ? "there are no tasks"
                                          : fmt::format("no task {}: there are 0 to {}", id, head.task_count - 1)));
    return std::move(read_chunk(folder, head, id / head.chunk_size)[id % head.chunk_size]);
}

TaskTable read_task_table(const fs::path& folder)
{
    TaskTable table = read_task_head(folder);
    for (std::size_t chunk = 0; chunk * table.chunk_size < table.task_count; ++chunk)
        for (Task& task : read_chunk(folder, table, chunk))
            table.tasks.push_back(std::move(task));
    return table;
}

}  // namespace fresco::host
