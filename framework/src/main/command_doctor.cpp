#include "base/common.h"
#include "main/commands.h"

#include "base/machine.h"
#include "base/text.h"
#include "plugins/plugin_library.h"
#include "plugins/plugin_search.h"
#include "run/commands_inspect.h"

#include <boost/version.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <map>
#include <set>
#include <unistd.h>

namespace fresco::host
{
namespace
{

/// The graphics cards as the driver lists them, or a line that says it lists nothing.
std::string cuda_text()
{
    std::ifstream driver("/proc/driver/nvidia/version");
    std::string line;
    return std::getline(driver, line) ? line : "no NVIDIA driver: tensors are computed on the processor";
}

/// Library -> versions, over all plugins.
std::map<std::string, std::set<std::string>> library_versions(const Catalog& catalog)
{
    std::map<std::string, std::set<std::string>> versions;
    for (const TypeDescription* type : catalog.types())
        for (const auto& [name, version] : type->library_versions.as_map())
            versions[name].insert(version.as_string());
    return versions;
}

std::map<std::string, int> types_per_library(const Catalog& catalog)
{
    std::map<std::string, int> counts;
    for (const TypeDescription* type : catalog.types())
        ++counts[type->library.string()];
    return counts;
}

void print_text(const Catalog& catalog)
{
    using Kind = TextTable::Kind;
    const std::size_t width = terminal_width(STDOUT_FILENO);
    const auto print = [&](const std::string& text) { fmt::print("{}\n", folded(harmless(text, LineEnds::none), width, 2)); };
    const Value processor = processor_capability();
    const auto versions = library_versions(catalog);
    const auto torch = versions.find("libtorch");
    TextTable facts({{"", Kind::figure}, {"", Kind::text}});
    facts.add({"fresco", program_version()});
    facts.add({"compiler", fmt::format("{}, {}", sdk_stamp().compiler, sdk_stamp().standard_library)});
    facts.add({"Boost", BOOST_LIB_VERSION});
    facts.add({"processor", processor.at("model").as_string() + ", " + std::to_string(available_cores()) + " cores"});
    facts.add({"instruction sets", processor.at("features").as_string()});
    facts.add({"libtorch", torch == versions.end() ? "no plugin uses it" : fmt::format("{}", fmt::join(torch->second, ", "))});
    facts.add({"CUDA", cuda_text()});
    fmt::print("{}\nlibraries behind the plugins\n", facts.text(width));
    TextTable libraries({{"", Kind::figure}, {"", Kind::text}}, 2);
    for (const auto& [name, found] : versions)
        libraries.add({name, fmt::format("{}", fmt::join(found, ", "))});
    fmt::print("{}\nplugin folders\n", libraries.text(width));
    for (const auto& folder : plugin_folders())
        print(fmt::format("  {}  ({}{})", folder.path.string(), folder.origin,
                          std::filesystem::exists(folder.path) ? "" : ", does not exist"));
    fmt::print("\nplugins\n");
    for (const auto& [library, count] : types_per_library(catalog))
        print(fmt::format("  {}  ({} {})", library, count, count == 1 ? "type" : "types"));
    for (const std::string& line : unusable_lines(catalog))
        print("  " + line);
}

}  // namespace

void add_doctor_command(CLI::App& app, int& exit_code)
{
    CLI::App* command =
        app.add_subcommand("doctor", "Show libraries, graphics card and plugins; exit code 4 if one cannot be used");
    command->callback(
        [&exit_code]
        {
            Catalog catalog = load_catalog();
            open_all(catalog);
            warn_of_plugin_folders();
            print_text(catalog);
            exit_code = catalog.refusals().empty() && catalog.ambiguous().empty() ? 0 : 4;
        });
}

}  // namespace fresco::host
