#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include "display/display.h"
#include "main/commands.h"

#include "base/machine.h"
#include "report/report.h"
#include "run/commands_inspect.h"
#include "run/exports.h"
#include "run/output_record.h"
#include "run/scheduler.h"
#include "run/stage_choice.h"
#include "run/tasks.h"
#include "store/stage_record.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <optional>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

struct RunArguments
{
    std::vector<std::string> words;  ///< Words of the command line.
    PipelineArguments pipeline;
    PlaceArguments places;
    int cores = available_cores();
    double memory_mb = 0;
    int jobs = 0;
    bool keep_going = false;
    std::string thumbnails;
    bool quiet = false;
    bool json_log = false;
    StageLimits limits;
    bool no_report = false;
    std::string task;
    bool only_stored = false;
};

DisplayKind display_kind(const RunArguments& arguments)
{
    if (arguments.json_log)
        return DisplayKind::json;
    if (arguments.quiet)
        return DisplayKind::quiet;
    const char* terminal = std::getenv("TERM");
    const bool can_move = isatty(STDERR_FILENO) != 0 && terminal != nullptr && std::string_view(terminal) != "dumb";
    return can_move ? DisplayKind::live : DisplayKind::plain;
}

void print_table(const RunSummary& summary)
{
    using Kind = TextTable::Kind;
    TextTable table({{"stage", Kind::figure}, {"", Kind::figure}, {"time", Kind::number}, {"peak memory", Kind::number}});
    for (const auto& stage : summary.stages)
    {
        const bool ran = stage.seconds > 0 || stage.memory_mb > 0;
        table.add({stage.stage, std::string(to_string(stage.state)), ran ? duration_text(stage.seconds) : "",
                   stage.memory_mb > 0 ? size_text(stage.memory_mb) : ""});
    }
    fmt::print("\n{}", table.text(terminal_width(STDOUT_FILENO)));
}

void print_files(const RunSummary& summary)
{
    constexpr std::ptrdiff_t shown_per_stage = 8;
    for (auto begin = summary.files.begin(); begin != summary.files.end();)
    {
        const auto end = std::find_if(begin, summary.files.end(), [&](const auto& file) { return file.stage != begin->stage; });
        for (auto file = begin; file != begin + std::min(shown_per_stage, end - begin); ++file)
            print_line(path_text(file->path) + (file->written ? "" : "  (unchanged)"));
        if (end - begin > shown_per_stage)
            fmt::print("… and {} more files of {}\n", end - begin - shown_per_stage, begin->stage);
        begin = end;
    }
}

/// The last event of a run, as a line.
std::string summary_event(const RunSummary& summary, const std::vector<ReportOutcome>& reports)
{
    Value::List pages;
    for (const ReportOutcome& report : reports)
        if (report.there)
            pages.push_back(Value::Map{{"path", report.file.string()}, {"written", report.written}});
    Value::List stages = each<Value>(
        summary.stages,
        [&](const auto& stage)
        {
            return Value::Map{{"stage", stage.stage},     {"type", stage.type},           {"state", to_string(stage.state)},
                              {"seconds", stage.seconds}, {"memory_mb", stage.memory_mb}, {"disk_mb", stage.disk_mb},
                              {"object", stage.object},   {"error", stage.error}};
        });
    Value::List files;
    for (const auto& file : summary.files)
        files.push_back(Value::Map{{"stage", file.stage}, {"path", file.path.string()}, {"written", file.written}});
    return to_json(Value::Map{{"event", "summary"},
                              {"exit_code", summary.exit_code},
                              {"stages", std::move(stages)},
                              {"files", std::move(files)},
                              {"reports", std::move(pages)}}) +
           "\n";
}

/// Events of the run in its folder of results, for programs that watch it: progress.jsonl.
class ProgressFile
{
  public:
    /// Throws Error if it cannot be written, or the user's own file is in the way.
    explicit ProgressFile(const RunRequest& run) : folder_(run.out), owner_{run.pipeline->file, "", "", ""}
    {
        const fs::path path = folder_ / name;
        FileHashes hashes({});
        OutputRecord record(folder_);
        if (const std::string reason = run.replace ? "" : record.obstacle(name, owner_, hashes); !reason.empty())
            refuse_obstacles({path.string() + ": " + reason + "; " + obstacle_advice});
        make_folder_or(folder_, "choose another with --out");
        record.begin({{name, ""}}, owner_, hashes);
        // Whoever still reads the last run's keeps it.
        fs::remove(path);
        file_.reset(std::fopen(path.c_str(), "wxe"));
        if (!file_)
            throw Error(path.string() + ": cannot be written: " + std::strerror(errno));
        // Whoever watches the run sees by the lock that it has not been killed.
        struct flock lock = {};
        lock.l_type = F_WRLCK;
        fcntl(fileno(file()), F_OFD_SETLK, &lock);
    }

    std::FILE* file() const { return file_.get(); }
    /// Writes the last event.
    void end(const std::string& event)
    {
        const fs::path path = folder_ / name;
        struct stat own = {};
        const bool written =
            std::fputs(event.c_str(), file()) >= 0 && std::fflush(file()) == 0 && fstat(fileno(file()), &own) == 0;
        file_.reset();
        const auto there = path_status(path);
        // Another run into this folder may have replaced it, or a user removed it.
        if (written && there && there->st_ino == own.st_ino)
            attempt([&] { OutputRecord(folder_).wrote({{name, file_hash(path)}}, owner_); });
    }

  private:
    static constexpr const char* name = "progress.jsonl";
    fs::path folder_;
    OutputOwner owner_;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_{nullptr, std::fclose};
};

/// Whether a folder is an input, or in one: what a run writes there would change what its stages read.
bool is_in_input(const fs::path& folder, const Pipeline& pipeline)
{
    const fs::path place = resolved(folder) / "";
    return std::ranges::any_of(named_inputs(pipeline), [&](const fs::path& input)
                               { return place.string().starts_with((resolved(input) / "").string()); });
}

/// Throws UsageError for an argument that needs a matrix, in a pipeline without one.
void check_matrix_options(const RunArguments& arguments, const Pipeline& pipeline)
{
    const char* option = arguments.keep_going            ? "--keep-going"
                         : arguments.jobs > 0            ? "--jobs"
                         : !arguments.thumbnails.empty() ? "--thumbnails"
                                                         : nullptr;
    if (option != nullptr && pipeline.sweep.axes.empty())
        throw UsageError(
            fmt::format("{}: error: only for pipelines with a 'matrix'; {} has none", option, arguments.pipeline.file));
    const std::vector<std::string> names = each(pipeline.stages, &PipelineStage::own_name);
    if (!arguments.thumbnails.empty() && std::ranges::find(names, arguments.thumbnails) == names.end())
        throw UsageError(fmt::format("--thumbnails {}: error: unknown stage '{}'{}", arguments.thumbnails, arguments.thumbnails,
                                     suggestion(arguments.thumbnails, names)));
}

/// The last lines of a run that has no table of combinations.
void print_summary(const RunArguments& arguments, const RunSummary& summary, const std::vector<ReportOutcome>& reports)
{
    if (arguments.json_log)
        return fmt::print("{}", summary_event(summary, reports));
    if (arguments.quiet)
        return;
    print_table(summary);
    print_files(summary);
    for (const ReportOutcome& report : reports)
        if (report.there)
            print_line(path_text(report.file) + (report.written ? "" : "  (unchanged)"));
}

/// For machines, the problems that were printed, and the exit code that they lead to, which is returned.
int tell_problems(const RunArguments& arguments, const std::vector<Problem>& problems, int exit_code)
{
    if (arguments.json_log)
        fmt::print("{}\n", to_json(Value::Map{
                               {"event", "problems"}, {"exit_code", exit_code}, {"problems", problems_as_value(problems)}}));
    return exit_code;
}

/// Reports the stages without a result, the only failure of a run with --only-stored.
int missing_results(const RunSummary& summary)
{
    std::vector<std::string> missing;
    for (const StageOutcome& stage : summary.stages)
        if (stage.state == StageState::blocked)
            missing.push_back(stage.stage);
    if (missing.empty())
        return summary.exit_code;
    print_message(fmt::format("error: {} no cached result, such as {}; run {} first",
                              missing.size() == 1 ? "1 stage has" : fmt::format("{} stages have", missing.size()),
                              missing.front(), missing.size() == 1 ? "it" : "them"));
    return static_cast<int>(ProblemKind::missing_input);
}

/// Summarizes a matrix that has run: writes sweep.json and its page beside the results; prints a line per combination if `print`.
/// `thumbnails`: the stage whose pictures the page shows, see write_sweep_summary.
void tell_combinations(const ReportRequest& run, const std::string& thumbnails, bool print)
{
    const auto outcomes = combination_outcomes(*run.run->pipeline, *run.summary, Store(run.run->store));
    const SweepSummaryFiles files = write_sweep_summary(run, outcomes, thumbnails);
    if (!files.note.empty())
        print_message(files.note);
    if (!print)
        return;
    fmt::print("\n{}", sweep_table(run.run->pipeline->sweep, outcomes, terminal_width(STDOUT_FILENO)));
    for (const auto& file : {files.json, files.page})
        if (!file.empty())
            print_line(path_text(file));
}

int run(const RunArguments& arguments)
{
    const bool is_task = !arguments.task.empty();
    PipelineRequest wanted = arguments.pipeline.request();
    // The tasks of other combinations have nothing to do with a missing input.
    wanted.keep_going = arguments.keep_going || is_task;
    const auto loaded = load_and_report(wanted);
    if (!loaded->result.problems.empty())
        return tell_problems(arguments, loaded->result.problems, loaded->result.exit_code());
    const Pipeline& pipeline = loaded->result.pipeline;
    int code_left_out = 0;
    if (!loaded->result.left_out.empty() && !is_task)
    {
        print_message("the other combinations run (--keep-going)");
        code_left_out = tell_problems(arguments, loaded->result.left_out, static_cast<int>(ProblemKind::missing_input));
    }
    check_matrix_options(arguments, pipeline);
    arguments.places.check();
    RunRequest request;
    request.pipeline = &pipeline;
    request.cores = arguments.cores;
    request.memory_mb = arguments.memory_mb > 0 ? arguments.memory_mb : available_memory_mb();
    request.store = arguments.places.store_folder();
    request.out = arguments.places.out_folder();
    request.jobs = std::max(1, arguments.jobs);
    request.keep_going = wanted.keep_going;
    request.until = arguments.pipeline.until;
    request.replace = arguments.places.replace;
    request.only_stored = arguments.only_stored;
    request.limits = arguments.limits;
    if (is_task)
        request.part = task_part(pipeline, arguments.pipeline.until, arguments.task);
    else
        refuse_obstacles(report_obstacles(request, !arguments.no_report));
    std::optional<ProgressFile> progress;
    auto display = make_display(display_kind(arguments));
    if (!arguments.no_report && !is_task && !is_in_input(request.out, pipeline))
        display = make_recording_display(std::move(display), progress.emplace(request).file());
    const auto begin = std::chrono::steady_clock::now();
    RunSummary summary = run_pipeline(request, *display);
    if (summary.exit_code == 0)
        summary.exit_code = arguments.only_stored ? missing_results(summary) : code_left_out;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    const ReportRequest ended{&request, &summary, &loaded->catalog, arguments.words, elapsed.count(), summary.exit_code == 75};
    std::vector<ReportOutcome> reports;
    if (!arguments.no_report && !is_task)
        reports = write_reports(ended);
    for (const ReportOutcome& report : reports)
        if (!report.note.empty())
            display->note(report.note);
    display.reset();  // off the terminal before anything else is printed
    if (progress)
        progress->end(summary_event(summary, reports));
    const bool sweep = !pipeline.sweep.axes.empty() && !is_task;
    if (sweep)
        tell_combinations(ended, arguments.thumbnails, !arguments.quiet && !arguments.json_log);
    if (!sweep || arguments.json_log)
        print_summary(arguments, summary, reports);
    std::fflush(stdout);
    if (summary.exit_code == 75 && !arguments.json_log)
        print_message("interrupted; run the same command to resume");
    return summary.exit_code;
}

}  // namespace

void add_run_command(CLI::App& app, const std::vector<std::string>& words, int& exit_code)
{
    CLI::App* command = app.add_subcommand("run", "Run a pipeline, skipping cached stages");
    const auto arguments = std::make_shared<RunArguments>();
    arguments->words = words;
    arguments->pipeline.add_to(*command);
    arguments->places.add_out_to(*command);
    arguments->places.add_store_to(*command);
    command->add_option("--cores", arguments->cores, "Processor cores to use")->check(CLI::Range(1, 4096))->default_str("all");
    command
        ->add_option("--memory", arguments->memory_mb,
                     "Memory budget for parallel stages in megabytes (default: what is free now)")
        ->check(CLI::Range(1.0, 1e9));
    arguments->pipeline.add_until_to(*command);
    command->add_option("--jobs", arguments->jobs, "Combinations of a matrix to run in parallel (default: 1)")
        ->check(CLI::Range(1, 4096));
    command->add_flag("--keep-going", arguments->keep_going, "Start further combinations of a matrix after one has failed");
    const auto limit =
        [&](const char* name, double& value, const std::map<std::string, double>& units, double least, const char* help)
    { command->add_option(name, value, help)->transform(CLI::AsNumberWithUnit(units))->check(CLI::Range(least, 1e9)); };
    limit("--stage-memory", arguments->limits.memory_mb, {{"M", 1}, {"G", 1024}}, 16,
          "Maximum memory of each stage's processes: megabytes, or with a unit, such as 4G");
    limit("--stage-time", arguments->limits.seconds, {{"s", 1}, {"m", 60}, {"h", 3600}}, 0.1,
          "Maximum time of each stage: seconds, or with a unit, such as 10m or 2h");
    command->add_option("--thumbnails", arguments->thumbnails,
                        "Stage of a matrix whose pictures sweep.html shows (default: the last that makes pictures)");
    command->add_flag("--no-report", arguments->no_report, "Write no run.json, report.html or progress.jsonl");
    command->add_flag("--quiet", arguments->quiet, "Print only errors");
    command->add_flag("--json-log", arguments->json_log, "Print one JSON object per event to standard output");
    auto* task = command->add_option("--task", arguments->task, "Run only this task of 'fresco plan FILE --tasks'");
    auto* only_stored = command->add_flag("--only-stored", arguments->only_stored,
                                          "Run no stage; write the outputs and reports of cached results");
    only_stored->excludes(task);
    for (const char* other : {"--jobs", "--keep-going", "--thumbnails", "--no-report"})
        task->excludes(other);
    command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace fresco::host
