#include "plugins/plugin_library.h"
#include "base/common.h"
#include "base/process.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/process.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <ranges>
#include <utility>

namespace fresco::host
{
namespace
{

constexpr std::chrono::minutes longest_opening{1};

/// Throws Error where the plugin was not built for this fresco.
void check_stamp(const JsonPlace& stamp)
{
    const auto number = [&](const char* name) { return static_cast<std::uint32_t>(stamp[name].integer(0, 0xFFFFFFFF)); };
    const auto text = [&](const char* name) { return stamp[name].text().c_str(); };
    // Fields behind another ABI number may be anything.
    fresco_plugin_info info{number("magic"), number("abi"), "", "", "", "", ""};
    if (info.magic == sdk_stamp().magic && info.abi == sdk_stamp().abi)
        info = {info.magic,         info.abi,      text("compiler"), text("standard_library"),
                text("containers"), text("torch"), text("cuda")};
    if (const auto problem = handshake_problem(info, sdk_stamp()))
        throw Error(*problem);
}

/// Finds libraries as the loader does for a plugin. Only fresco's own must be there: the loader may find others elsewhere.
std::vector<fs::path> own_libraries(const std::vector<std::string>& names, const fs::path& plugin)
{
    const fs::path sdk = sdk_library();
    const std::vector<fs::path> folders = own_library_folders(plugin);
    std::vector<fs::path> found;
    for (const std::string& name : names)
    {
        std::error_code error;
        const auto folder = std::ranges::find_if(folders, [&](const fs::path& each) { return fs::exists(each / name, error); });
        if (name == sdk.filename())
            found.push_back(sdk);
        else if (folder != folders.end())
            found.push_back(*folder / name);
        else if (name.starts_with("libfresco_"))
            throw Error("needs " + name + ", which is neither beside it nor in " + folders.back().string());
    }
    return found;
}

std::string end_text(const HeardEnd& end)
{
    if (end.timed_out)
        return "did not return within a minute when it was opened";
    return end.signal != 0 ? "crashed when it was opened: " + signal_text(end.signal)
                           : "ended the process with exit code " + std::to_string(end.exit_code) + " when it was opened";
}

}  // namespace

PluginDescription read_description(const fs::path& library)
{
    const std::string id = build_id(library);
    const fs::path file = fs::path(library).replace_extension(".json");
    const std::string undescribed = "was built without its description: build it with fresco_add_plugin, which writes ";
    if (std::error_code error; !fs::exists(file, error))
        throw Error(undescribed + file.string());
    const Value whole = parse_json(read_text_file(file), file.string());
    const JsonPlace description(whole, file.string());
    if (const std::string& described = description["build_id"].text(); described != id)
        throw Error(undescribed + file.string() + ": that one describes the build " + described + ", the library is the build " +
                    id);
    check_stamp(description["handshake"]);
    description.has_only({"build_id", "handshake", "versions", "own_libraries", "types"});
    PluginDescription read{{library}, description["versions"].value(), {}};
    std::ranges::copy(own_libraries(description["own_libraries"].texts(), library), std::back_inserter(read.files));
    for (const JsonPlace& type : description["types"].list())
        read.types.push_back({type["type"].text(), type["kind"].text(), type["help"].text(), type["declaration"].value()});
    return read;
}

OpenPlugin open_plugin(const fs::path& library)
{
    PluginDescription description = read_description(library);
    const PluginLibrary& plugin = PluginLibrary::open(library);
    std::error_code error;
    for (const fs::path& loaded : loaded_libraries())
        for (const fs::path& file : description.files | std::views::drop(1))
            if (loaded.filename() == file.filename() && !fs::equivalent(loaded, file, error))
                throw Error("runs with " + loaded.string() + " instead of " + file.string() +
                            ": unset LD_LIBRARY_PATH, or build the plugin with fresco_add_plugin");
    return {&plugin, PluginBytes(std::move(description.files))};
}

std::vector<Refusal> refused_when_opened(const std::set<fs::path>& libraries)
{
    std::vector<Refusal> refused;
    for (auto next = libraries.begin(); next != libraries.end();)
    {
        const fs::path& first = *next;
        std::vector<Refusal> refused_here;
        std::vector<std::string> words{"internal-open"};
        std::transform(next, libraries.end(), std::back_inserter(words),
                       [](const fs::path& library) { return library.string(); });
        const auto take = [&](const std::string& reason)
        {
            if (next == libraries.end())
                return;
            if (!reason.empty())
                refused_here.push_back({*next, reason});
            ++next;
        };
        const HeardEnd end = hear_out(start_child(words), longest_opening, take, [](const std::string&) {});
        if (next != libraries.end())
            take(end_text(end));
        for (const Refusal& refusal : refused_here)
            // A library opened before it in the same process may be the cause.
            std::ranges::copy(refusal.library == first ? std::vector{refusal} : refused_when_opened({refusal.library}),
                              std::back_inserter(refused));
    }
    return refused;
}

void open_all(Catalog& catalog)
{
    std::set<fs::path> libraries;
    for (const TypeDescription* type : catalog.types())
        libraries.insert(type->library);
    for (Refusal& refusal : refused_when_opened(libraries))
        catalog.add(std::move(refusal));
}

void internal_open(const std::vector<std::string>& libraries)
{
    for (const std::string& library : libraries)
    {
        std::string reason;
        try
        {
            open_plugin(library);
        }
        catch (const std::exception& error)
        {
            reason = error.what();
            std::ranges::replace(reason, '\n', ' ');
        }
        write_all(child_channel, reason + "\n");
    }
    // Static destructors of libraries have nothing to do here that is worth a crash.
    std::_Exit(0);
}

}  // namespace fresco::host
