#include "main/commands.h"

#include "base/machine.h"
#include "plugins/plugin_library.h"
#include "plugins/plugin_search.h"

#include <algorithm>
#include <boost/version.hpp>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{

/// What the driver says of the graphics cards, or that there is none.
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

std::string joined(const std::set<std::string>& texts)
{
    std::string text;
    for (const auto& entry : texts)
        text += (text.empty() ? "" : ", ") + entry;
    return text;
}

void print_json(const Catalog& catalog)
{
    Value::Map libraries;
    for (const auto& [name, versions] : library_versions(catalog))
        libraries.emplace_back(name, Value::List(versions.begin(), versions.end()));
    Value::List folders;
    for (const auto& folder : plugin_folders())
        folders.push_back(Value::Map{{"path", folder.path.string()}, {"origin", folder.origin}});
    Value::List plugins;
    for (const auto& [library, count] : types_per_library(catalog))
        plugins.push_back(Value::Map{{"library", library}, {"types", count}});
    Value::List unbuilt;
    for (const auto& plugin : catalog.unbuilt())
        unbuilt.push_back(Value::Map{{"type", plugin.type}, {"reason", plugin.reason}});
    Value::List refusals;
    for (const auto& refusal : catalog.refusals())
        refusals.push_back(Value::Map{{"library", refusal.library.string()}, {"reason", refusal.reason}});
    fmt::print("{}\n", to_json(Value::Map{{"version", program_version()},
                                          {"compiler", host_stamp().compiler},
                                          {"standard_library", host_stamp().standard_library},
                                          {"processor", processor_capability()},
                                          {"cores", available_cores()},
                                          {"cuda", cuda_text()},
                                          {"libraries", std::move(libraries)},
                                          {"folders", std::move(folders)},
                                          {"plugins", std::move(plugins)},
                                          {"refusals", std::move(refusals)},
                                          {"unbuilt", std::move(unbuilt)}},
                               2));
}

void print_text(const Catalog& catalog)
{
    const Value processor = processor_capability();
    fmt::print("fresco            {}\n", program_version());
    fmt::print("compiler          {}, {}\n", host_stamp().compiler, host_stamp().standard_library);
    fmt::print("Boost             {}\n", BOOST_LIB_VERSION);
    fmt::print("processor         {}, {} cores\n", processor.at("model").as_string(), available_cores());
    fmt::print("instruction sets  {}\n", processor.at("features").as_string());
    const auto versions = library_versions(catalog);
    const auto torch = versions.find("libtorch");
    fmt::print("libtorch          {}\n", torch == versions.end() ? "no plugin uses it" : joined(torch->second));
    fmt::print("CUDA              {}\n", cuda_text());
    fmt::print("descriptions      {}\n", descriptor_cache_folder().string());
    fmt::print("\nlibraries behind the plugins\n");
    for (const auto& [name, found] : versions)
        fmt::print("  {:<16}{}\n", name, joined(found));
    fmt::print("\nplugin folders\n");
    for (const auto& folder : plugin_folders())
        fmt::print("  {}  ({}{})\n", folder.path.string(), folder.origin,
                   std::filesystem::exists(folder.path) ? "" : ", not there");
    fmt::print("\nplugins\n");
    for (const auto& [library, count] : types_per_library(catalog))
        fmt::print("  {}  ({} {})\n", library, count, count == 1 ? "type" : "types");
    for (const auto& refusal : catalog.refusals())
        fmt::print("  refused: {}: {}\n", refusal.library.string(), refusal.reason);
    for (const auto& plugin : catalog.unbuilt())
        fmt::print("  not built: {}{}\n", plugin.type, plugin.reason.empty() ? "" : ": " + plugin.reason);
}

}  // namespace

void add_doctor_command(CLI::App& app, int& exit_code)
{
    CLI::App* command =
        app.add_subcommand("doctor", "Show libraries, graphics card and plugins; exit code 4 if a plugin is refused");
    const auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "Print JSON");
    command->callback(
        [json, &exit_code]
        {
            const Catalog catalog = load_catalog(true);
            *json ? print_json(catalog) : print_text(catalog);
            exit_code = catalog.refusals().empty() ? 0 : 4;
        });
}

}  // namespace fresco::host
