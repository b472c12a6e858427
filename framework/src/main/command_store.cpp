#include "base/common.h"
#include "base/text.h"
#include "main/commands.h"

#include "base/machine.h"
#include "store/store_tidy.h"

#include <ctime>
#include <fmt/format.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

struct StoreArguments
{
    PlaceArguments places;
    bool dry_run = false;
    double keep_days = 7;
};

std::string days_text(double days)
{
    return days < 1 ? fmt::format("{:.0f} h", days * 24) : fmt::format("{:.0f} d", days);
}

std::string age_text(std::int64_t time_s)
{
    return days_text((static_cast<double>(std::time(nullptr)) - static_cast<double>(time_s)) / 86400.0);
}

int list(const StoreArguments& arguments)
{
    const Store store = arguments.places.existing_store();
    const auto objects = list_objects(store);
    double total = 0;
    using Kind = TextTable::Kind;
    TextTable table(
        {{"", Kind::figure}, {"", Kind::figure}, {"", Kind::figure}, {"", Kind::number}, {"", Kind::number}, {"", Kind::figure}});
    for (const auto& object : objects)
    {
        total += object.disk_mb;
        table.add({object.id, object.stage, object.type, size_text(object.disk_mb), object.whole ? age_text(object.time_s) : "",
                   !object.whole   ? "unfinished"
                   : object.in_use ? "in use"
                                   : ""});
    }
    fmt::print("{}{} results, {}\n", table.text(terminal_width(STDOUT_FILENO)), objects.size(), size_text(total));
    return 0;
}

int verify(const StoreArguments& arguments)
{
    const Store store = arguments.places.existing_store();
    const auto damages = verify_store(store, available_cores());
    for (const auto& damage : damages)
        print_line("damaged: " + damage.text);
    if (damages.empty())
        fmt::print("no result is damaged\n");
    else
        fmt::print("{}: a run that reads one recomputes it\n", counted(damages.size(), "damaged result"));
    return damages.empty() ? 0 : 1;
}

int tidy(const StoreArguments& arguments)
{
    const Store store = arguments.places.existing_store();
    const TidyResult result = tidy_store(store, arguments.keep_days, arguments.dry_run);
    const std::size_t width = terminal_width(STDOUT_FILENO);
    TextTable table({{"", TextTable::Kind::figure}, {"", TextTable::Kind::figure}, {"", TextTable::Kind::number}});
    for (const auto& object : result.removed)
        table.add({object.id, object.stage, size_text(object.disk_mb)});
    const std::string counts = fmt::format("{} {} results ({}), {} checkpoints, {} leftovers of killed runs",
                                           arguments.dry_run ? "would remove" : "removed", result.removed.size(),
                                           size_text(result.freed_mb), result.checkpoints, result.leftovers);
    fmt::print("{}{}\n", table.text(width), folded(counts, width));
    if (result.kept > 0)
        print_line(fmt::format("kept {} ({}) of pipelines whose files are missing, but which ran in the last {} (--keep-days {})",
                               counted(static_cast<std::size_t>(result.kept), "result"), size_text(result.kept_mb),
                               days_text(arguments.keep_days), arguments.keep_days));
    for (const std::string& stuck : result.stuck)
        print_line("cannot be removed: " + stuck);
    return 0;
}

}  // namespace

void add_store_command(CLI::App& app, int& exit_code)
{
    CLI::App* command = app.add_subcommand("store", "List, verify or clean up stored results");
    command->require_subcommand(1);
    const auto arguments = std::make_shared<StoreArguments>();
    const auto add = [&](const char* name, const char* help, int (*action)(const StoreArguments&))
    {
        CLI::App* sub = command->add_subcommand(name, help);
        arguments->places.add_store_to(*sub);
        sub->callback([arguments, action, &exit_code] { exit_code = action(*arguments); });
        return sub;
    };
    add("ls", "List the results", list);
    add("verify", "Verify every result against its hashes; exit code 1 if any is damaged", verify);
    CLI::App* gc = add("gc", "Remove results that no pipeline's last run used and that are older than --keep-days", tidy);
    gc->add_option("--keep-days", arguments->keep_days,
                   "Keep results and checkpoints younger than this, and the last results of pipelines that ran since")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    gc->add_flag("--dry-run", arguments->dry_run, "Show what would be removed without removing it");
}

}  // namespace fresco::host
