#include "printed_line.h"

#include <fresco/command.h>
#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/process.h>
#include <fresco/programs/run_program.h>
#include <fresco/stage.h>

#include <cstdio>
#include <deque>
#include <fmt/format.h>
#include <map>

using namespace fresco;
using namespace fresco::command;

namespace
{

namespace fs = std::filesystem;

constexpr std::size_t shown_lines = 200;
constexpr std::size_t kept_lines = 12;

fs::path made(const fs::path& folder)
{
    fs::create_directories(folder);
    return folder;
}

std::string shown_command(const std::vector<std::string>& words)
{
    std::string text;
    for (const std::string& word : words)
    {
        const bool quoted = word.empty() || word.find_first_of(" '\"") != std::string::npos;
        text += (text.empty() ? "" : " ") + (quoted ? to_json(word) : word);
    }
    constexpr std::size_t longest = 300;
    return text.size() <= longest ? text : text.substr(0, longest) + "…";
}

/// Shows what a program prints, and keeps the last of it for an error.
class Printed
{
  public:
    explicit Printed(RunContext& run) : run_(run) {}

    void take(const std::string& line)
    {
        if (const auto said = said_to_host(line))
            return pass_on(*said, line);
        const std::string shown = printable(line);
        if (shown.find_first_not_of(' ') == std::string::npos)
            return;
        tail_.push_back(shown);
        if (tail_.size() > kept_lines)
            tail_.pop_front();
        if (++lines_ <= shown_lines)
            run_.message(shown);
        else
            std::fputs((shown + "\n").c_str(), stdout);
        if (lines_ == shown_lines)
            run_.message("(it prints more; all of it is in --json-log)");
        std::fflush(stdout);
    }

    std::string tail() const
    {
        std::string text = tail_.empty() ? "; it printed nothing" : "; the last it printed:";
        for (const std::string& line : tail_)
            text += "\n    | " + line;
        return text;
    }

  private:
    void pass_on(const SaidToHost& said, const std::string& line)
    {
        switch (said.kind)
        {
        case SaidToHost::Kind::progress:
            return run_.progress(said.done, said.total, said.text);
        case SaidToHost::Kind::metric:
            return run_.metric(said.text, said.done);
        case SaidToHost::Kind::warning:
            return run_.warning(said.text);
        case SaidToHost::Kind::message:
            return run_.message(said.text);
        case SaidToHost::Kind::report:
            try
            {
                return run_.report(said.text, parse_json(said.json, "report"));
            }
            catch (const Error& error)
            {
                return run_.warning("cannot parse " + printable(line) + " (" + error.what() + ")");
            }
        }
    }

    RunContext& run_;
    std::deque<std::string> tail_;
    std::size_t lines_ = 0;
};

class Command final : public Stage
{
    Option<CommandLine> run_{
        this, "run", required,
        "The program and its arguments, run without a shell; {port} stands for the path of an input or output"};
    Option<InputFiles> files_{
        this, "files", InputFiles{},
        "Files that the program needs, such as scripts; an argument that names one becomes its absolute path"};
    Option<std::string> version_{this, "version", "",
                                 "Any text; change it to run the program again, for example after an update"};
    Option<bool> gpu_{this,       "gpu",         false, "Whether the program needs a GPU; a cluster starts it where there is one",
                      not_in_key, chooses_device};
    InputPorts inputs_{this, "inputs", "Input ports, wired by input"};
    OutputPorts outputs_{this, "outputs", "Output ports, made by the program"};
    Slot<ImageIo> images_{this, ForForm{"png"}, "Reads and writes pictures for ports with 'as: png'"};

    void run(RunContext& run) override
    {
        const fs::path scratch = run.scratch_folder();
        const ImageIo* images = images_.has_value() ? images_.get().get() : nullptr;
        std::map<std::string, std::string> paths;
        for (const auto& [name, file] : files_->paths)
            paths[name] = file;
        for (const auto& port : *inputs_)
        {
            run.check_canceled();
            paths[port->name()] = port->hand_over(made(scratch / "in" / port->name()), images, run);
        }
        for (const auto& port : *outputs_)
            paths[port->name()] = port->place(made(scratch / "out" / port->name()));

        execute(words(paths), scratch, run);
        for (const auto& port : *outputs_)
            try
            {
                port->take_back(scratch / "out" / port->name(), images, run);
            }
            catch (const Error& error)
            {
                throw Error("the program succeeded, but its output '" + port->name() + "' (" + port->type().name +
                            ") cannot be used: " + error.what());
            }
    }

    std::vector<std::string> words(const std::map<std::string, std::string>& paths) const
    {
        std::vector<std::string> words;
        for (const std::string& word : run_->words)
            words.push_back(files_->paths.contains(word) ? paths.at(word) : filled_in(word, paths));
        return words;
    }

    static void execute(const std::vector<std::string>& words, const fs::path& scratch, RunContext& run)
    {
        EnvironmentChanges environment{{"TMPDIR", made(scratch / "tmp").string()},
                                       // Lines when they are printed, nothing written beside the user's scripts.
                                       {"PYTHONUNBUFFERED", "1"},
                                       {"PYTHONDONTWRITEBYTECODE", "1"}};
        const std::string threads = std::to_string(run.threads());
        for (const char* name : {"FRESCO_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"})
            environment.emplace_back(name, threads);
        Printed printed(run);
        const std::string file = find_program(words.front());
        if (file.empty())
            throw Error(words.front() + ": program not found" +
                        (words.front().find('/') == std::string::npos ? " in PATH" : " or not executable"));
        const ProcessEnd end = programs::run_program(
            {.file = file, .arguments = words, .environment = environment, .folder = made(scratch / "work").string()}, run,
            [&](const std::string& line) { printed.take(line); });
        if (end.signal != 0)
            throw Error("'" + shown_command(words) + "' was killed by a signal: " + signal_text(end.signal) + printed.tail());
        if (end.exit_code != 0)
            throw Error(fmt::format("'{}' ended with exit code {}{}", shown_command(words), end.exit_code, printed.tail()));
    }
};

}  // namespace

FRESCO_STAGE("command", Command, "Any program as a stage, with ports declared in the pipeline")
