#include "plugins/plugin_probe.h"
#include "base/common.h"
#include "base/machine.h"
#include "base/process.h"
#include "plugins/catalog.h"
#include "plugins/plugin_library.h"
#include <fresco/error.h>
#include <fresco/reader.h>
#include <fresco/stage.h>
#include <fresco/viewer.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <iostream>
#include <new>
#include <poll.h>
#include <thread>
#include <unistd.h>

namespace fresco::host
{
namespace
{

using Clock = std::chrono::steady_clock;
constexpr double limit_s = 5;
constexpr double hard_limit_s = 60;
/// More than any library takes to say what it holds.
constexpr double most_memory_mb = 4096;

void tell(const Value& line)
{
    const std::string text = to_json(line) + "\n";
    // Without a channel someone runs it by hand and reads the lines.
    if (fcntl(child_channel, F_GETFD) < 0 || !send_all(child_channel, text))
        std::cout << text << std::flush;
}

Value describe_type(const PluginLibrary::Entry& entry, const Configurable& object)
{
    Value declaration = object.describe();
    const auto texts = [](const std::vector<std::string>& all) { return Value::List(all.begin(), all.end()); };
    const auto check = [&](const void* as, std::string_view kind, const char* word, const char* base)
    {
        if (as == nullptr && entry.kind == kind)
            throw Error("the type " + entry.type + " is registered as a " + word + " but does not derive from fresco::" + base);
        return as != nullptr;
    };
    if (const auto* stage = dynamic_cast<const Stage*>(&object); check(stage, "stage", "stage", "Stage"))
        declaration.set("cost", describe_cost(entry.type, stage->cost(), declaration.at("options")));
    if (const auto* origin = dynamic_cast<const FileOrigin*>(&object))
        declaration.set("extensions", texts(origin->extensions()));
    if (const auto* reader = dynamic_cast<const FileReader*>(&object);
        check(reader, FileReader::component_kind, "reader", "FileReader"))
    {
        declaration.set("artifact", reader->artifact());
        declaration.set("extensions", texts(reader->extensions()));
        declaration.set("formats", each<Value>(reader->formats(), &FileFormat::describe));
    }
    if (const auto* viewer = dynamic_cast<const Viewer*>(&object); check(viewer, Viewer::component_kind, "viewer", "Viewer"))
    {
        declaration.set("artifact", viewer->type().name);
        declaration.set("extensions", texts(viewer->extensions()));
    }
    return Value::Map{{"type", entry.type}, {"kind", entry.kind}, {"help", entry.help}, {"declaration", std::move(declaration)}};
}

struct RunningProbe
{
    Child child;
    LineBuffer lines;
    LineBuffer printed;
    std::string step = "it was opened";
    Clock::time_point start = Clock::now();
    double cpu_before = 0;
    Clock::time_point busy_last = Clock::now();
    bool timed_out = false;
    bool loops = false;
    bool done = false;
    std::string foreign;  ///< What the library wrote over the channel, in words.
    Probe probe;
};

double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

struct ProcessLoad
{
    double cpu_seconds = 0;
    bool asleep = false;  ///< Waits for something other than a processor or a disk.
};

ProcessLoad load_of(pid_t pid)
{
    std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const auto name_end = text.rfind(')');
    if (name_end == std::string::npos)
        return {};
    text.erase(0, name_end + 1);
    char state = 0;
    unsigned long user = 0;
    unsigned long system = 0;
    if (std::sscanf(text.c_str(), " %c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lu %lu", &state, &user, &system) != 3)
        return {};
    return {static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK)), state == 'S'};
}

/// 5 s of work, or 5 s of sleep without any: a slow start on a busy machine must not get a good library refused.
void check_time(RunningProbe& running)
{
    if (running.timed_out)
        return;
    const ProcessLoad load = load_of(running.child.pid);
    if (!load.asleep || load.cpu_seconds > running.cpu_before)
    {
        running.cpu_before = load.cpu_seconds;
        running.busy_last = Clock::now();
    }
    running.loops = load.cpu_seconds >= limit_s - 0.5;
    if (running.loops || seconds_since(running.busy_last) > limit_s || seconds_since(running.start) > hard_limit_s)
    {
        running.timed_out = true;
        kill(running.child.pid, SIGKILL);
    }
}

/// Throws Error if internal_probe does not write such a line.
void take_line(RunningProbe& running, const std::string& text)
{
    const Value line = parse_json(text, "probe");
    if (const auto* step = line.find("step"))
        running.step = step->as_string();
    else if (const auto* refusal = line.find("refusal"))
    {
        running.probe.refusal = refusal->as_string();
        running.probe.lasting = line.at("lasting").as_bool();
    }
    else
        running.probe.description = line.at("description");
}

void take_lines(RunningProbe& running)
{
    running.lines.read_from(running.child.channel.get());
    running.printed.read_from(running.child.output.get());
    std::string text;
    while (running.lines.next(text))
    {
        try
        {
            take_line(running, text);
        }
        catch (const Error&)
        {
            constexpr std::size_t shown = 60;
            if (running.foreign.empty())
                running.foreign = "wrote " + to_json(text.substr(0, shown)) + " to descriptor " + std::to_string(child_channel) +
                                  ", the host's channel, when " + running.step;
        }
    }
}

/// True once the child has ended and the probe is complete.
bool finish(RunningProbe& running)
{
    ProcessEnd end;
    if (!take_group_end(running.child.pid, end))
        return false;
    take_lines(running);
    Probe& probe = running.probe;
    if (running.timed_out)
        probe.refusal = "did not return within 5 s when " + running.step;
    else if (end.signal != 0)
        probe.refusal = "crashed when " + running.step + ": " + signal_text(end.signal);
    else if (!running.foreign.empty())
        // It would write over what its stages tell, too.
        probe.refusal = running.foreign;
    else if (probe.refusal.empty() && probe.description.is_null())
        probe.refusal = "ended the process with exit code " + std::to_string(end.exit_code) + " when " + running.step;
    else
        return true;
    probe.description = Value();
    // Probe again next time if the process timed out, was killed, or may have lacked memory, descriptors or threads.
    // OpenBLAS interrupts a process in which it cannot start its threads.
    const bool lacked =
        memory_limit_mb() > 0 || end.signal == SIGKILL || end.signal == SIGINT || (end.signal == 0 && end.exit_code != 0);
    probe.lasting = running.timed_out ? running.loops : !lacked;
    return true;
}

}  // namespace

std::vector<Probe> probe_plugins(const std::vector<std::filesystem::path>& libraries, int parallel)
{
    std::vector<Probe> results;
    std::vector<RunningProbe> running;
    std::size_t next = 0;
    const Orphans orphans;
    const double limit_mb = std::min(most_memory_mb, machine_memory_mb() / 2);
    while (next < libraries.size() || !running.empty())
    {
        while (next < libraries.size() && running.size() < static_cast<std::size_t>(std::max(parallel, 1)))
        {
            RunningProbe started;
            started.probe.library = libraries[next];
            started.child = start_child({"internal-probe", libraries[next].string()}, {}, limit_mb);
            running.push_back(std::move(started));
            ++next;
        }
        std::vector<pollfd> descriptors;
        for (const auto& entry : running)
            for (const FileDescriptor* from : {&entry.child.channel, &entry.child.output})
                descriptors.push_back({from->get(), POLLIN, 0});
        poll(descriptors.data(), descriptors.size(), 20);
        for (auto& entry : running)
        {
            take_lines(entry);
            check_time(entry);
            entry.done = finish(entry);
            if (entry.done)
                results.push_back(std::move(entry.probe));
        }
        std::erase_if(running, [](const RunningProbe& entry) { return entry.done; });
        if (!running.empty())
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    orphans.end({});
    return results;
}

int internal_probe(const std::filesystem::path& library)
{
    try
    {
        const PluginLibrary& plugin = PluginLibrary::open(library);
        Value::List types;
        for (const auto& entry : plugin.entries())
        {
            tell(Value::Map{{"step", "an object of type " + entry.type + " was made"}});
            const std::unique_ptr<Configurable> object = plugin.make(entry.type);
            types.push_back(describe_type(entry, *object));
        }
        Value description =
            Value::Map{{"types", std::move(types)},
                       {"versions", plugin.versions()},
                       {"own_libraries", each<Value>(plugin.own_libraries(), [&](const auto& file) { return file.string(); })}};
        tell(Value::Map{{"description", std::move(description)}});
        // Static destructors of libraries have nothing to do here that is worth a crash.
        std::_Exit(0);
    }
    catch (const std::exception& error)
    {
        const std::string text = error.what();
        // A library that is not installed today may be tomorrow, and a file that cannot be opened or read can be by then.
        const bool lasting =
            text.find("cannot be ") == std::string::npos && dynamic_cast<const std::bad_alloc*>(&error) == nullptr;
        tell(Value::Map{{"refusal", text}, {"lasting", lasting}});
        std::_Exit(4);
    }
}

}  // namespace fresco::host
