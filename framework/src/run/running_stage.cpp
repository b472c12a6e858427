#include "run/running_stage.h"
#include "base/common.h"
#include "base/text.h"
#include "pipeline/pipeline_options.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/process.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>

namespace fresco::host
{

namespace
{

constexpr std::size_t tail_lines = 12;

/// Environment of the libraries behind a stage. What the user has set stays, except the number of threads.
EnvironmentChanges library_environment(int threads)
{
    EnvironmentChanges changes;
    for (const char* name : {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"})
        changes.emplace_back(name, std::to_string(threads));
    const auto propose = [&](const char* name, const char* value)
    {
        if (std::getenv(name) == nullptr)
            changes.emplace_back(name, value);
    };
    // glibc gives blocks of more than 32 MB back at once, so that each tensor of a step is made of fresh pages: a third of a
    // step's time. Kept instead, and in huge pages where the system allows it.
    propose("GLIBC_TUNABLES",
            "glibc.malloc.hugetlb=1:glibc.malloc.mmap_threshold=1073741824:glibc.malloc.trim_threshold=4294967296");
    // Threads of OpenMP that wait keep a core busy; others may need it.
    propose("GOMP_SPINCOUNT", "1000");
    return changes;
}

}  // namespace

std::filesystem::path preview_folder(const std::filesystem::path& out, const PipelineStage& stage)
{
    return out / stage.place / "progress" / stage.own_name;
}

Value make_worker_request(const StageNode& node, const RunState& state, const Store& store, const fs::path& out, int threads,
                          FileHashes& hashes)
{
    const PipelineStage& stage = *node.stage;
    Value::List inputs;
    for (const Wire& wire : stage.wires)
    {
        StoredResult made;
        for (const std::size_t place : node.producers)
            if (const StageNode& producer = state.nodes()[place]; producer.stage->name == wire.from_stage)
                made = *producer.result;
        inputs.push_back(Value::Map{{"port", wire.port},
                                    {"from", wire.from_stage + "." + wire.from_port},
                                    {"object", made.object},
                                    {"output", wire.from_port},
                                    {"references", Value::List(made.references.begin(), made.references.end())},
                                    {"file", wire.file.string()},
                                    {"reader", wire.reader}});
    }
    Value libraries = Value::Map{{stage.type->type, stage.type->library.string()}};
    for (const TypeDescription* component : stage.components)
        libraries.set(component->type, component->library.string());
    const auto dependency = [&](const fs::path& file) { return to_value(hashes.dependency(file)); };
    return Value::Map{{"store", store.root().string()},
                      {"out", out.string()},
                      {"preview_folder", preview_folder(out, stage).string()},
                      {"stage", stage.name},
                      {"type", stage.type->type},
                      {"options", *stage.options},
                      {"key", node.key},
                      {"key_document", node.key_document},
                      {"inputs", std::move(inputs)},
                      {"libraries", std::move(libraries)},
                      {"files", each<Value>(stage.input_files, dependency)},
                      {"threads", threads},
                      {"on_gpu", works_on_gpu(stage)}};
}

RunningStage::RunningStage(StageNode& node, const Value& request, const Store& store, const StageLimits& limits,
                           ProgressDisplay& display)
    : node_(&node), store_(&store), limits_(limits), display_(&display),
      threads_(static_cast<int>(request.at("threads").as_int())), request_folder_(store.make_temporary()),
      resumes_(is_folder(store.checkpoint(node.key))), log_(store.log_file(node.key))
{
    for (const Value& input : request.at("inputs").as_list())
    {
        inputs_.insert(input.at("object").as_string());
        for (const Value& reference : input.at("references").as_list())
            inputs_.insert(reference.as_string());
    }
    const fs::path file = request_folder_ / "request.json";
    write_file(file, to_json(request));
    child_ = start_child({"internal-run", file.string()}, library_environment(threads_), limits_.memory_mb);
}

RunningStage::~RunningStage()
{
    // A worker that crashed left its own, too.
    store_->remove_temporaries(request_folder_.filename().string());
    remove_scratch_folders(request_folder_.filename().string());
}

void RunningStage::stop(int signal) const
{
    if (signal == SIGKILL)
    {
        // It must not end before what it started: nobody could tell those any more.
        kill(child_.pid, SIGSTOP);
        signal_descendants(child_.pid, SIGKILL);
    }
    kill(child_.pid, signal);
}

void RunningStage::end_for(std::string limit, int signal)
{
    // A tenth of its time to write a checkpoint in.
    const double patience_s = std::clamp(limits_.seconds / 10, 0.5, 5.0);
    limit_text_ = std::move(limit);
    kill_time_ = std::chrono::steady_clock::now() + std::chrono::milliseconds(std::lround(1000 * patience_s));
    stop(signal);
}

void RunningStage::hold_to_limits()
{
    const auto now = std::chrono::steady_clock::now();
    if (!limit_text_.empty())
    {
        if (now > kill_time_)
            stop(SIGKILL);
        return;
    }
    // In order, so that a stage with checkpoints goes on from there when it is given more time.
    if (runs_ && limits_.seconds > 0 && elapsed() > limits_.seconds)
        return end_for("it exceeded the time limit of " + duration_text(limits_.seconds) +
                           ": raise --stage-time, or find out where it hangs",
                       SIGTERM);
    if (limits_.memory_mb <= 0 || now < memory_time_)
        return;
    memory_time_ = now + std::chrono::milliseconds(100);
    if (const double used = memory_of_tree_mb(child_.pid); used > limits_.memory_mb)
        end_for("it used " + size_text(used) + " of memory; the limit is " + size_text(limits_.memory_mb) +
                    ": raise --stage-memory, or ask for less (smaller sizes, fewer frames, --cores 1)",
                SIGKILL);
}

void RunningStage::take_event(const std::string& line)
{
    const Value event = parse_json(line, "worker");
    const std::string& name = event.at("event").as_string();
    const std::string& stage = node_->stage->name;
    if (name == "running")
    {
        start_ = std::chrono::steady_clock::now();
        runs_ = true;
        display_->stage_begins(stage, threads_);
        try
        {
            log_.begin(resumes_);
        }
        catch (const Error& error)
        {
            display_->stage_says(stage, std::string("no log is written: ") + error.what(), true);
        }
    }
    else if (name == "waiting")
        display_->stage_waits(stage, event.at("holder").as_string());
    else if (name == "progress")
        display_->stage_progress(stage, event.at("done").as_double(), event.at("total").as_double(), event.at("unit").as_string(),
                                 event.at("metrics"));
    else if (name == "message" || name == "warning")
    {
        const std::string& text = event.at("text").as_string();
        log_.add(name == "warning" ? "warning: " + text : text);
        display_->stage_says(stage, text, name == "warning");
    }
    else if (name == "damaged" && inputs_.contains(event.at("object").as_string()))
        answer_.damage = Damage{event.at("object").as_string(), event.at("text").as_string()};
    else if (name == "failed")
    {
        answer_.failure = event.at("text").as_string();
        log_.add("error: " + answer_.failure);
    }
    else if (name == "canceled")
        answer_.was_canceled = true;
    else if (name == "done")
        take_result(event);
}

void RunningStage::take_result(const Value& event)
{
    const std::string& object = event.at("object").as_string();
    // The plugin can write to the channel, too: no stage gets another's result by that.
    if (!object.starts_with(object_prefix(node_->key)))
        return;
    answer_.result = StoredResult{object, each(event.at("references").as_list(), &Value::as_string), {}};
    answer_.was_stored = event.at("stored").as_bool();
    answer_.took = {event.at("seconds").as_double(), event.at("memory_mb").as_double(), event.at("disk_mb").as_double()};
}

void RunningStage::take_print(const std::string& line)
{
    ++printed_lines_;
    display_->stage_prints(node_->stage->name, line);
    log_.add(line);
    tail_.push_back(line);
    if (tail_.size() > tail_lines)
        tail_.pop_front();
}

void RunningStage::take_events()
{
    events_.read_from(child_.channel.get());
    output_.read_from(child_.output.get());
    // The event that opens its log may arrive together with what it printed afterward.
    while (!runs_ && take_next_event())
    {
    }
    std::string line;
    while (output_.next(line))
        take_print(line);
    while (take_next_event())
    {
    }
    log_.flush();
}

/// Returns false once no event is waiting.
bool RunningStage::take_next_event()
{
    std::string line;
    if (!events_.next(line))
        return false;
    try
    {
        take_event(line);
    }
    catch (const Error&)
    {
        // Written by something else in the process, over the host's channel.
        if (!line.empty())
            display_->stage_prints(node_->stage->name, line);
    }
    return true;
}

bool RunningStage::ended()
{
    if (!take_group_end(child_.pid, end_))
        return false;
    take_events();
    if (const std::string rest = output_.rest(); !rest.empty())
        take_print(rest);
    if (!limit_text_.empty())
        log_.add("error: " + limit_text_);
    else if (end_.signal != 0)
        log_.add("error: its process ended: " + signal_text(end_.signal));
    log_.flush();
    return true;
}

/// Explains the end of a process that gave no reason itself.
std::string RunningStage::end_text() const
{
    const auto says_it = [](const std::string& line) { return line.find(std::strerror(EAGAIN)) != std::string::npos; };
    const bool may_lack_processes = end_.signal != SIGKILL && std::ranges::any_of(tail_, says_it);
    const std::string report = may_lack_processes
                                   ? "; if no more processes or threads may be started, raise the limit (ulimit -u)"
                                   : "; please report it to the author of the plugin " + node_->stage->type->library.string();
    std::string text;
    if (end_.signal == SIGKILL && oom_kills() > oom_kills_)
        text = "its process was killed, most likely because the machine ran out of memory (it had used " +
               size_text(end_.peak_memory_mb) + "): close other programs or ask for less";
    else if (end_.signal == SIGKILL)
        text = "its process was killed from outside: by a user, a debugger, or the system (it had used " +
               size_text(end_.peak_memory_mb) + " of memory); run again to resume";
    else if (end_.signal != 0)
        text = "its process crashed: " + signal_text(end_.signal) + report;
    else
        text = "its process ended with exit code " + std::to_string(end_.exit_code) + " before the stage was done" + report;
    if (limits_.memory_mb > 0 && end_.signal != 0)
        text += "; it had used " + size_text(end_.peak_memory_mb) + " of its limit of " + size_text(limits_.memory_mb) +
                " (--stage-memory)";
    if (!tail_.empty())
        text += "; the last it printed:";
    for (const auto& line : tail_)
        text += "\n    | " + line;
    return text;
}

std::string RunningStage::failure_text(const fs::path& pipeline) const
{
    const bool said = exceeded_limit() || !answer_.failure.empty();
    const std::string text = !said ? end_text() : exceeded_limit() ? limit_text_ : with_process_limit(answer_.failure);
    const bool shown = !said && printed_lines_ <= tail_lines;
    if (shown || printed_lines_ == 0)
        return text;
    const std::string place = path_text(store_->root());
    return text + "\n    all that it printed: fresco log " + shell_word(path_text(pipeline)) + " " +
           shell_word(node_->stage->name) + (place == default_store ? "" : " --store " + shell_word(place));
}

int RunningStage::failure_code() const
{
    // Without a reason, any library in the process may have chosen the exit code.
    const int code = answer_.failure.empty() || exceeded_limit() ? worker_failed : end_.exit_code;
    return code == worker_missing_input || code == worker_plugin ? code : worker_failed;
}

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
        if ((kind == "input_file" || kind == "input_folder" || kind == "input_path") && value != nullptr &&
            !value->as_string().empty())
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

}  // namespace fresco::host
