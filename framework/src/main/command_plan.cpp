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

Value figures(const CostFigures& cost)
{
    return Value::Map{{"seconds", cost.seconds}, {"memory_mb", cost.memory_mb}, {"disk_mb", cost.disk_mb}};
}

void print_json(const Plan& plan, const std::vector<std::string>& notes)
{
    Value::List stages;
    for (const auto& stage : plan.stages)
        stages.push_back(Value::Map{{"stage", stage.stage},
                                    {"type", stage.type},
                                    {"runs", stage.runs},
                                    {"reason", stage.reason},
                                    {"cost", figures(stage.cost)},
                                    {"measured", stage.measured},
                                    {"files_to_copy", stage.files_to_copy}});
    print_value(Value::Map{{"stages", std::move(stages)},
                           {"total", figures(plan.total)},
                           {"obstacles", Value::List(plan.obstacles.begin(), plan.obstacles.end())},
                           {"notes", Value::List(notes.begin(), notes.end())}});
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

void print_text(const Plan& plan, const std::vector<std::string>& notes, const std::string& out)
{
    using Kind = TextTable::Kind;
    const std::size_t width = terminal_width(STDOUT_FILENO);
    TextTable table({{"stage", Kind::name},
                     {"", Kind::figure},
                     {"time", Kind::number},
                     {"memory", Kind::number},
                     {"disk", Kind::number},
                     {"why", Kind::text}});
    for (const auto& stage : plan.stages)
        table.add({stage.stage, stage.runs ? "run" : "-",
                   stage.runs ? (stage.measured ? "" : "~") + duration_text(stage.cost.seconds) : "",
                   stage.runs ? size_text(stage.cost.memory_mb) : "", stage.runs ? size_text(stage.cost.disk_mb) : "",
                   stage.reason});
    fmt::print("{}", table.text(width));
    const auto runs = std::ranges::count_if(plan.stages, [](const auto& stage) { return stage.runs; });
    const std::string copies = copies_text(plan, out);
    if (!copies.empty())
        fmt::print("{}\n", folded(copies, width));
    for (const auto& obstacle : plan.obstacles)
        fmt::print("{}\n", folded("a run would stop: " + harmless(obstacle, LineEnds::none), width));
    if (runs == 0)
    {
        if (copies.empty())
            fmt::print("nothing to do\n");
        return;
    }
    for (const auto& note : notes)
        fmt::print("{}\n", folded(harmless(note, LineEnds::none), width));
    fmt::print("{}\n", folded(fmt::format("about {} in all, at most {} of memory at a time per stage, {} more in the store (~: "
                                          "estimated, not yet measured here)",
                                          duration_text(plan.total.seconds), size_text(plan.total.memory_mb),
                                          size_text(plan.total.disk_mb)),
                              width));
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
    const PipelineEstimate estimate = estimate_pipeline(loaded->result.pipeline, arguments.cores);
    const Plan made =
        make_plan(loaded->result.pipeline, arguments.places.store_folder(), arguments.places.out_folder(),
                  arguments.pipeline.until, estimate.stages, arguments.places.upstream_folder(), arguments.places.replace);
    arguments.json ? print_json(made, estimate.notes) : print_text(made, estimate.notes, arguments.places.out_name());
    return 0;
}

}  // namespace

void add_plan_command(CLI::App& app, int& exit_code)
{
    CLI::App* command = app.add_subcommand("plan", "Show what a run would do, why, and its estimated cost");
    const auto arguments = std::make_shared<PlanArguments>();
    arguments->pipeline.add_to(*command);
    arguments->places.add_store_to(*command);
    arguments->places.add_upstream_to(*command);
    arguments->places.add_out_to(*command);
    arguments->pipeline.add_until_to(*command);
    command->add_option("--cores", arguments->cores, "Processor cores that the run will use")
        ->check(CLI::Range(1, 4096))
        ->default_str("all");
    auto* json = command->add_flag("--json", arguments->json, "Print JSON");
    command
        ->add_flag("--tasks", arguments->tasks,
                   "Print the pipeline's tasks for an execution engine, in JSON; 'fresco run FILE --task NAME' runs one of them")
        ->excludes(json)
        ->excludes("--upstream");
    command->callback([arguments, &exit_code] { exit_code = plan(*arguments); });
}

}  // namespace fresco::host
