#include "run/stage_failure.h"
#include "base/machine.h"
#include "base/unit_text.h"

#include <csignal>

namespace fresco::host
{

std::string stage_error_text(const PipelineStage& stage, const std::string& text)
{
    std::string result =
        to_string(Problem{stage.position, "stage " + stage.name + " (" + stage.type->type + "): " + text, ProblemKind::invalid});
    std::string worked_on;
    const auto add = [&](const std::string& name, const std::string& what)
    { worked_on += (worked_on.empty() ? "" : ", ") + name + " = " + what; };
    for (const auto& wire : stage.wires)
        add(wire.port, wire.from_stage.empty() ? wire.file.string() : wire.from_stage + "." + wire.from_port);
    for (const auto& option : stage.type->declaration.at("options").as_list())
    {
        const std::string& kind = option.at("kind").as_string();
        const Value* value = stage.options->find(option.at("name").as_string());
        if ((kind == "input_file" || kind == "input_folder") && value != nullptr && !value->as_string().empty())
            add(option.at("name").as_string(), value->as_string());
    }
    if (!worked_on.empty())
        result += "\n    it worked on " + worked_on;
    return result;
}

std::string repeated_damage_text(const Damage& damage, const RunState& state)
{
    std::string text = damage.text + "; it was recomputed and is damaged again: check this machine's disk and memory";
    for (const StageNode& node : state.nodes())
        if (damage.object.starts_with(object_prefix(node.key)))
            text += ", and whether stage " + node.stage->name + " (plugin " + node.stage->type->library.string() +
                    ") leaves threads that write into its outputs";
    return text;
}

namespace
{

/// What it did not say itself.
std::string end_text(const RunningStage& running)
{
    const ProcessEnd& end = running.end();
    std::string text;
    if (end.exit_code == worker_lost_channel)
        text = "it closed descriptor " + std::to_string(child_channel) +
               ", by which it speaks to the host; please report it to the author of the plugin " +
               running.node().stage->type->library.string();
    else if (end.signal == SIGKILL && running.memory_ran_out())
        text = "its process was killed, most likely because the machine ran out of memory (it had used " +
               size_text(end.peak_memory_mb) + "): close other programs or ask for less";
    else if (end.signal == SIGKILL)
        text = "its process was killed from outside: by a user, a debugger, or the system (it had used " +
               size_text(end.peak_memory_mb) + " of memory); run again to resume";
    else if (end.signal == SIGABRT && memory_limit_mb() > 0)
        text = "its process ended itself, most likely because it may use no more than " + size_text(memory_limit_mb()) +
               " of memory: raise the limit (ulimit -d, ulimit -v)";
    else if (end.signal != 0)
        text = "its process crashed: " + signal_text(end.signal) + "; please report it to the author of the plugin " +
               running.node().stage->type->library.string();
    else
        text = "its process ended with exit code " + std::to_string(end.exit_code) +
               " before the stage was done; please report it to the author of the plugin " +
               running.node().stage->type->library.string();
    if (running.limits().memory_mb > 0 && end.signal != 0)
        text += "; it had used " + size_text(end.peak_memory_mb) + " of its limit of " + size_text(running.limits().memory_mb) +
                " (--isolate-memory)";
    if (const std::string tail = running.printed_tail(); !tail.empty())
        text += "; the last it printed:" + tail;
    return text;
}

}  // namespace

std::string failure_text(const RunningStage& running, const std::filesystem::path& pipeline, const std::filesystem::path& store)
{
    const bool said = !running.limit_text().empty() || !running.failure().empty();
    const std::string text = !said ? end_text(running) : running.limit_text().empty() ? running.failure() : running.limit_text();
    const bool shown = !said && running.printed_lines() <= RunningStage::tail_lines;
    if (shown || running.printed_lines() == 0)
        return text;
    const std::string place = path_text(store);
    return text + "\n    all that it printed: fresco log " + shell_word(path_text(pipeline)) + " " +
           shell_word(running.node().stage->name) + (place == default_store ? "" : " --store " + shell_word(place));
}

int failure_code(const RunningStage& running)
{
    // Of a code without a word about it anything in the process may be the cause.
    const int code = running.failure().empty() || !running.limit_text().empty() ? worker_failed : running.end().exit_code;
    return code == worker_missing_input || code == worker_plugin ? code : worker_failed;
}

}  // namespace fresco::host
