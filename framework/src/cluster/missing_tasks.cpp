#include "cluster/missing_tasks.h"

#include <algorithm>
#include <cmath>

namespace fresco::host
{
namespace
{

constexpr double time_factor = 2;
constexpr double memory_factor = 1.3;
/// Starting a process on a busy file server takes its time too.
constexpr int least_minutes = 5;
constexpr int least_memory_mb = 500;

/// Slurm takes a ',' in a job's name for the end of it.
std::string array_group(const std::string& group)
{
    std::string text = group;
    std::replace(text.begin(), text.end(), ',', '+');
    return text;
}

}  // namespace

const Attempt* TaskKnowledge::in_queue(std::size_t task) const
{
    const auto found = attempts.find(task);
    if (found == attempts.end())
        return nullptr;
    for (const Attempt& attempt : found->second)
        if (queue.elements.contains(attempt.element))
            return &attempt;
    return nullptr;
}

void set_limits(QueuedTask& task, const TaskGroup& group, const Attempt* last, const TaskLog& log)
{
    task.minutes = std::max(least_minutes, static_cast<int>(std::ceil(time_factor * group.seconds / 60)));
    task.memory_mb = std::max(least_memory_mb, static_cast<int>(std::ceil(memory_factor * group.memory_mb)));
    if (last == nullptr)
        return;
    task.minutes = std::max(task.minutes, last->minutes * (log.time_ran_out() ? 2 : 1));
    task.memory_mb = std::max(task.memory_mb, last->memory_mb * (log.memory_ran_out() ? 2 : 1));
}

MissingTasks missing_tasks(const TaskTable& table, const TaskKnowledge& known, const std::filesystem::path& folder,
                           std::size_t round, std::size_t room)
{
    MissingTasks result;
    enum class Fate
    {
        settled,  ///< Done, in the queue, or to be queued.
        left,
        blocked
    };
    std::vector<Fate> fates(table.tasks.size(), Fate::settled);
    for (const Task& task : table.tasks)
    {
        if (known.done[task.id])
            continue;
        if (const Attempt* attempt = known.in_queue(task.id))
        {
            result.queued[task.id] = {attempt->element.first, attempt->element.second, true};
            continue;
        }
        const auto attempts = known.attempts.find(task.id);
        const Attempt* last = attempts == known.attempts.end() ? nullptr : &attempts->second.back();
        const auto any_need = [&](Fate fate)
        { return std::any_of(task.needs.begin(), task.needs.end(), [&](std::size_t need) { return fates[need] == fate; }); };
        if ((last != nullptr && last->round == round) || any_need(Fate::blocked))
        {
            fates[task.id] = Fate::blocked;
            ++result.blocked;
            continue;
        }
        if (result.tasks.size() >= room || any_need(Fate::left))
        {
            fates[task.id] = Fate::left;
            ++result.left;
            continue;
        }
        const TaskGroup& group = table.groups[task.group];
        QueuedTask queued{task.id, array_group(group.name), task_name(table, task), task.needs, 0, 0, group.threads, group.gpu};
        set_limits(queued, group, last, last == nullptr ? TaskLog{} : last_log(folder, queued.name));
        result.tasks.push_back(std::move(queued));
    }
    return result;
}

}  // namespace fresco::host
