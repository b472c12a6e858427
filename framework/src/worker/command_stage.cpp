#include "command_forms.h"
#include "command_words.h"

#include <fresco/error.h>
#include <fresco/hash.h>
#include <fresco/host/command_stage.h>
#include <fresco/host/process.h>
#include <fresco/host/process_tree.h>
#include <fresco/host/worker.h>
#include <fresco/stage.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <functional>
#include <map>
#include <poll.h>
#include <sys/prctl.h>
#include <unistd.h>
#include <utility>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

/// Of the forms in which artifacts are exchanged, and of what a command is told: another number is another key.
constexpr int command_format = 1;
constexpr std::size_t shown_lines = 200;
constexpr std::size_t kept_lines = 12;

/// An option of a kind that is this stage's alone.
class Declared final : public Parameter
{
  public:
    using Assigned = std::function<void(const Value&)>;

    Declared(Configurable* owner, const char* name, OptionKind kind, Value default_value, const char* help,
             Assigned assigned = {})
        : Parameter(
              owner,
              {.name = name, .kind = kind, .default_value = default_value, .required = default_value.is_null(), .help = help}),
          assigned_(std::move(assigned))
    {
    }

    const Value& operator*() const { return value_; }

  private:
    void set(const Value& value, ComponentFactory&) override
    {
        value_ = value;
        if (assigned_)
            assigned_(value_);
    }

    Assigned assigned_;
    Value value_{Value::Map{}};
};

CommandPort port_from(const Value& value)
{
    return {value.at("artifact").as_string(), value.at("as").as_string()};
}

int version_of(const Value& value)
{
    return static_cast<int>(value.at("version").as_int());
}

class CommandInput final : public InputPort
{
  public:
    CommandInput(Configurable* owner, const std::string& name, const Value& port)
        : InputPort(owner, name, port.at("artifact").as_string(), version_of(port), false, ""), port_(port_from(port))
    {
    }

    void load(const ArtifactFolder& folder) override { stored_ = folder; }
    void set(std::shared_ptr<const Artifact> value) override { value_ = std::move(value); }

    fs::path hand_to_program(const fs::path& folder, const ImageIo* images) const
    {
        return hand_over(port_, stored_, value_.get(), folder, images);
    }

  private:
    CommandPort port_;
    ArtifactFolder stored_;
    std::shared_ptr<const Artifact> value_;
};

class CommandOutput final : public OutputPort
{
  public:
    CommandOutput(Configurable* owner, const std::string& name, const Value& port)
        : OutputPort(owner, name, port.at("artifact").as_string(), version_of(port), ""), port_(port_from(port))
    {
    }

    // It is in its folder once it was taken.
    void save() const override {}
    std::shared_ptr<const Artifact> value() const override { return nullptr; }

    fs::path place(const fs::path& scratch) const { return place_for(port_, scratch, folder_.path); }
    void take(const fs::path& path, const ImageIo* images, RunContext& run) const
    {
        try
        {
            take_back(port_, path, folder_, images, run);
        }
        catch (const Error& error)
        {
            throw Error("the program ended well, but its output '" + name() + "' (" + artifact() +
                        ") cannot be used: " + error.what());
        }
    }

  private:
    CommandPort port_;
};

/// While a program runs, the end of the host ends first what the program started, then this process; the kernel alone would leave
/// what is further down.
class HostWatch
{
  public:
    HostWatch()
    {
        // Nor what is printed to a host that is gone.
        signal(SIGPIPE, SIG_IGN);
        prctl(PR_SET_PDEATHSIG, SIGTERM);
    }
    HostWatch(const HostWatch&) = delete;
    HostWatch& operator=(const HostWatch&) = delete;
    ~HostWatch()
    {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        end_if_gone();
    }
    void end_if_gone() const
    {
        if (getppid() == host_)
            return;
        end_descendants();
        std::_Exit(worker_canceled);
    }

  private:
    const pid_t host_ = getppid();
};

std::string shown_command(const std::vector<std::string>& words)
{
    std::string text;
    for (const auto& word : words)
        text +=
            (text.empty() ? "" : " ") + (word.empty() || word.find_first_of(" '\"") != std::string::npos ? to_json(word) : word);
    constexpr std::size_t longest = 300;
    return text.size() <= longest ? text : text.substr(0, longest) + "…";
}

class CommandStage final : public Stage
{
    void run(RunContext& run) override
    {
        const fs::path scratch = run.scratch_folder();
        const ImageIo* images = images_.has_value() ? images_.get().get() : nullptr;
        std::map<std::string, std::string> values;
        for (const auto& [name, file] : (*files_).as_map())
            values[name] = file.as_string();
        for (const auto& port : input_ports_)
        {
            run.check_canceled();
            values[port->name()] = port->hand_to_program(made(scratch / "in" / port->name()), images);
        }
        for (const auto& port : output_ports_)
            values[port->name()] = port->place(made(scratch / "out" / port->name()));

        std::vector<std::string> words;
        for (const auto& word : (*run_).as_list())
        {
            const auto file = (*files_).find(word.as_string());
            words.push_back(file != nullptr ? file->as_string() : filled_in(word.as_string(), values));
        }
        execute(words, scratch, run);
        for (const auto& port : output_ports_)
            port->take(values[port->name()], images, run);
    }

    static fs::path made(const fs::path& folder)
    {
        fs::create_directories(folder);
        return folder;
    }

    void execute(const std::vector<std::string>& words, const fs::path& scratch, RunContext& run)
    {
        const EnvironmentChanges environment{{"TMPDIR", made(scratch / "tmp").string()},
                                             {"FRESCO_THREADS", std::to_string(run.threads())},
                                             // Lines when they are printed, nothing written beside the user's scripts.
                                             {"PYTHONUNBUFFERED", "1"},
                                             {"PYTHONDONTWRITEBYTECODE", "1"}};
        const HostWatch host;
        const Program program = start_program(words, environment, made(scratch / "work").string());
        LineBuffer output;
        ChildEnd end;
        for (bool ended = false; !ended;)
        {
            pollfd descriptor{program.output.get(), POLLIN, 0};
            poll(&descriptor, 1, 100);
            if ((descriptor.revents & POLLIN) == 0 && (descriptor.revents & POLLHUP) != 0)
                poll(nullptr, 0, 5);  // It closed its output and goes on.
            host.end_if_gone();
            stop_if_told(program, run);
            ended = take_end(program.pid, end);
            output.read_from(program.output.get());
            std::string line;
            while (output.next(line))
                take_line(line, run);
        }
        // What it left behind must not write into its outputs any more.
        end_descendants();
        if (const std::string rest = output.rest(); !rest.empty())
            take_line(rest, run);
        if (end.signal == 0 && end.exit_code == 0)
            return;
        throw Error("'" + shown_command(words) + "' " +
                    (end.signal != 0 ? "was ended by a signal: " + signal_text(end.signal)
                                     : "ended with exit code " + std::to_string(end.exit_code)) +
                    printed_tail());
    }

    /// SIGTERM to the program and all it started; SIGKILL to what is left when the program has ended, after 5 s at latest.
    static void stop_if_told(const Program& program, RunContext& run)
    {
        try
        {
            run.check_canceled();
        }
        catch (const Canceled&)
        {
            const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(5);
            signal_descendants(getpid(), SIGTERM);
            ChildEnd end;
            while (!take_end(program.pid, end) && std::chrono::steady_clock::now() < patience)
                poll(nullptr, 0, 20);
            end_descendants();
            throw;
        }
    }

    void take_line(const std::string& line, RunContext& run)
    {
        if (const auto said = said_to_host(line))
        {
            switch (said->kind)
            {
            case CommandLineSaid::Kind::progress:
                return run.progress(said->done, said->total, said->text);
            case CommandLineSaid::Kind::metric:
                return run.metric(said->text, said->done);
            case CommandLineSaid::Kind::warning:
                return run.warning(said->text);
            case CommandLineSaid::Kind::message:
                return run.message(said->text);
            case CommandLineSaid::Kind::report:
                try
                {
                    return run.report(said->text, parse_json(said->json, "report"));
                }
                catch (const Error& error)
                {
                    return run.warning("not understood: " + printable(line) + " (" + error.what() + ")");
                }
            }
        }
        const std::string shown = printable(line);
        if (shown.find_first_not_of(' ') == std::string::npos)
            return;
        tail_.push_back(shown);
        if (tail_.size() > kept_lines)
            tail_.pop_front();
        if (++lines_ <= shown_lines)
            run.message(shown);
        else
            std::fputs((shown + "\n").c_str(), stdout);
        if (lines_ == shown_lines)
            run.message("(it prints more; all of it is in --json-log)");
        std::fflush(stdout);
    }

    std::string printed_tail() const
    {
        std::string text = tail_.empty() ? "; it printed nothing" : "; the last it printed:";
        for (const auto& line : tail_)
            text += "\n    | " + line;
        return text;
    }

    Declared run_{this, "run", OptionKind::texts, Value(),
                  "The program and its words, not through a shell; {port} stands for the path of an input or output"};
    Declared files_{this, "files", OptionKind::input_files, Value::List{},
                    "Files that the program needs: scripts, settings; a word of run that names one becomes its path"};
    Option<std::string> version_{this, "version", "",
                                 "Change it to run again when something changed that is not among the files"};
    Declared inputs_{this,
                     "inputs",
                     OptionKind::ports,
                     Value::Map{},
                     "Ports that other stages or files are wired to by input",
                     [this](const Value& ports)
                     {
                         for (const auto& [name, port] : ports.as_map())
                             input_ports_.push_back(std::make_unique<CommandInput>(this, name, port));
                     }};
    Declared outputs_{this,
                      "outputs",
                      OptionKind::ports,
                      Value(),
                      "Ports that the program makes",
                      [this](const Value& ports)
                      {
                          for (const auto& [name, port] : ports.as_map())
                              output_ports_.push_back(std::make_unique<CommandOutput>(this, name, port));
                      }};
    Slot<ImageIo> images_{this, "images", "", "Reader and writer of pictures for ports with 'as: png'"};

    std::vector<std::unique_ptr<CommandInput>> input_ports_;
    std::vector<std::unique_ptr<CommandOutput>> output_ports_;
    std::deque<std::string> tail_;
    std::size_t lines_ = 0;
};

}  // namespace

TypeDescription command_type()
{
    const CommandStage stage;
    const Cost cost = stage.cost();
    TypeDescription type;
    type.type = command_type_name;
    type.kind = "stage";
    type.help = "Any program, with ports that the pipeline declares";
    type.declaration = stage.describe();
    type.declaration.set("cost", Value::Map{{"seconds", cost.seconds},
                                            {"memory_mb", cost.memory_mb},
                                            {"disk_mb", cost.disk_mb},
                                            {"frames", cost.frames},
                                            {"faces", cost.faces},
                                            {"height_squares", cost.height_squares}});
    std::error_code error;
    type.library = fs::read_symlink("/proc/self/exe", error);
    type.library_hash = content_hash("command " + std::to_string(command_format));
    type.library_versions = Value::Map{};
    return type;
}

std::unique_ptr<Configurable> make_command_stage()
{
    return std::make_unique<CommandStage>();
}

}  // namespace fresco::host
