#include "base/text.h"
#include "main/commands.h"

#include "base/machine.h"
#include "run/commands_inspect.h"
#include "run/plan.h"
#include "run/progress_display.h"
#include "run/tasks.h"

#include <algorithm>
#include <fmt/format.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

struct PlanArguments
{
    PipelineArguments pipeline;
    PlaceArguments places;
    int cores = available_cores();
    bool json = false;
    bool tasks = false;
};

void print_json(const Plan& plan)
{
    Value::List stages;
    for (const auto& stage : plan.stages)
        stages.push_back(Value::Map{{"stage", stage.stage},
                                    {"type", stage.type},
                                    {"chosen", Value::Map(stage.chosen.begin(), stage.chosen.end())},
                                    {"runs", stage.runs},
                                    {"reason", stage.reason},
                                    {"seconds", stage.measured ? Value(stage.measured->seconds) : Value()},
                                    {"memory_mb", stage.measured ? Value(stage.measured->memory_mb) : Value()},
                                    {"files_to_copy", stage.files_to_copy}});
    print_value(Value::Map{{"stages", std::move(stages)},
                           {"total", Value::Map{{"seconds", plan.total.seconds},
                                                {"memory_mb", plan.total.memory_mb},
                                                {"not_run_yet", plan.unmeasured_count}}},
                           {"obstacles", Value::List(plan.obstacles.begin(), plan.obstacles.end())}});
}

/// "copies 3 files of glb, views to out"; empty if nothing is copied.
std::string copies_text(const Plan& plan, const std::string& out)
{
    std::size_t files = 0;
    std::string stages;
    for (const auto& stage : plan.stages)
        if (stage.files_to_copy > 0)
        {
            files += stage.files_to_copy;
            stages += (stages.empty() ? "" : ", ") + stage.stage;
        }
    return files == 0 ? "" : fmt::format("copies {} of {} to {}", counted(files, "file"), stages, out);
}

/// "about 3 min in all, at most 2.1 GB of memory at a time per stage, and 2 stages that have not run yet"
std::string total_text(const Plan& plan)
{
    const auto runs = std::ranges::count_if(plan.stages, [](const auto& stage) { return stage.runs; });
    const std::string unmeasured = counted(plan.unmeasured_count, "stage") + (plan.unmeasured_count == 1 ? " has" : " have");
    if (runs == static_cast<std::ptrdiff_t>(plan.unmeasured_count))
        return unmeasured + " not run yet";
    return fmt::format("about {} in all, at most {} of memory at a time per stage{}", duration_text(plan.total.seconds),
                       size_text(plan.total.memory_mb), plan.unmeasured_count > 0 ? "; " + unmeasured + " not run yet" : "");
}

void print_text(const Plan& plan, const std::string& out)
{
    using Kind = TextTable::Kind;
    const std::size_t width = terminal_width(STDOUT_FILENO);
    TextTable table(
        {{"stage", Kind::figure}, {"", Kind::figure}, {"time", Kind::number}, {"memory", Kind::number}, {"why", Kind::text}});
    for (const auto& stage : plan.stages)
    {
        std::string why = stage.reason;
        for (const auto& [option, type] : stage.chosen)
            why += "; " + option + ": " + type;
        table.add({stage.stage, stage.runs ? "run" : "-",
                   !stage.runs      ? ""
                   : stage.measured ? duration_text(stage.measured->seconds)
                                    : "not run yet",
                   stage.runs && stage.measured ? size_text(stage.measured->memory_mb) : "", why});
    }
    fmt::print("{}", table.text(width));
    const bool runs = std::ranges::any_of(plan.stages, &PlannedStage::runs);
    const std::string copies = copies_text(plan, out);
    if (!copies.empty())
        fmt::print("{}\n", folded(copies, width));
    for (const auto& obstacle : plan.obstacles)
        fmt::print("{}\n", folded("a run would stop: " + harmless(obstacle, LineEnds::none), width));
    if (runs)
        fmt::print("{}\n", folded(total_text(plan), width));
    else if (copies.empty())
        fmt::print("nothing to do\n");
}

int plan(const PlanArguments& arguments)
{
    const auto loaded = load_and_report(arguments.pipeline.request());
    if (!loaded->result.problems.empty())
    {
        if (arguments.json)
            print_value(Value::Map{{"problems", problems_as_value(loaded->result.problems)}});
        return loaded->result.exit_code();
    }
    if (arguments.tasks)
    {
        print_value(plan_tasks(loaded->result.pipeline, arguments.pipeline.until, Store(arguments.places.store_folder()),
                               arguments.cores));
        return 0;
    }
    const Plan made = make_plan(loaded->result.pipeline, arguments.places.store_folder(), arguments.places.out_folder(),
                                arguments.pipeline.until, arguments.places.replace);
    arguments.json ? print_json(made) : print_text(made, arguments.places.out_name());
    return 0;
}

}  // namespace

void add_plan_command(CLI::App& app, int& exit_code)
{
    CLI::App* command = app.add_subcommand("plan", "Show what a run would do, why, and what it took last time");
    const auto arguments = std::make_shared<PlanArguments>();
    arguments->pipeline.add_to(*command);
    arguments->places.add_store_to(*command);
    arguments->places.add_out_to(*command);
    arguments->pipeline.add_until_to(*command);
    auto* cores = command->add_option("--cores", arguments->cores, "Processor cores of each task")
                      ->check(CLI::Range(1, 4096))
                      ->default_str("all");
    auto* json = command->add_flag("--json", arguments->json, "Print JSON");
    auto* tasks = command->add_flag(
        "--tasks", arguments->tasks,
        "Print the pipeline's tasks for an execution engine, in JSON; 'fresco run FILE --task NAME' runs one of them");
    tasks->excludes(json);
    cores->needs(tasks);
    command->callback([arguments, &exit_code] { exit_code = plan(*arguments); });
}

}  // namespace fresco::host
