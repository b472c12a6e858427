#include "plugins/own_libraries.h"

#include "base/unit_text.h"
#include "plugins/plugin_library.h"
#include <fresco/error.h>
#include <fresco/plugin.h>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/shared_library.hpp>
#include <cstdio>
#include <list>
#include <map>
#include <new>
#include <set>
#include <sys/resource.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

std::string hexadecimal(std::uint32_t value)
{
    char text[16];
    std::snprintf(text, sizeof text, "0x%08X", value);
    return text;
}

std::string text_of(const char* text)
{
    return text != nullptr ? text : "";
}

/// The loader's own words, without Boost's frame around them.
std::string loader_message(std::string text)
{
    const std::string_view before = "dlerror system message: ";
    if (const auto begin = text.find(before); begin != std::string::npos)
    {
        text.erase(0, begin + before.size());
        if (const auto end = text.rfind("): "); end != std::string::npos)
            text.erase(end);
    }
    return text;
}

/// Why the loader refused, and the limit on memory where it may have been that.
std::string loading_problem(const std::string& said)
{
    const bool no_room =
        said.find("failed to map segment") != std::string::npos || said.find("annot allocate memory") != std::string::npos;
    rlimit limit{};
    if (!no_room || getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return "cannot be loaded: " + said;
    return "cannot be loaded: there is not enough memory for it: raise the limit of " +
           size_text(static_cast<double>(limit.rlim_cur) / (1024.0 * 1024.0)) + " (ulimit -v); the loader said: " + said;
}

template <class Function>
Function required_symbol(const boost::dll::shared_library& library, const char* name)
{
    if (!library.has(name))
        throw Error(std::string("has no symbol ") + name +
                    ": not a fresco plugin, or built for another version of the handshake; build it with fresco_add_plugin");
    return &library.get<std::remove_pointer_t<Function>>(name);
}

}  // namespace

bool is_type_name(const std::string& type)
{
    char last = '.';
    for (const char c : type)
    {
        const bool word = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
        if (!word && (c != '.' || last == '.'))
            return false;
        last = c;
    }
    return last != '.';
}

const fresco_plugin_info& host_stamp()
{
    static constexpr fresco_plugin_info stamp{
        FRESCO_MAGIC, FRESCO_ABI, FRESCO_COMPILER_STAMP, FRESCO_STANDARD_LIBRARY_STAMP, FRESCO_CONTAINERS_STAMP, "", ""};
    return stamp;
}

std::optional<std::string> handshake_problem(const fresco_plugin_info& plugin, const fresco_plugin_info& host,
                                             const fresco_plugin_info* torch)
{
    const auto differs = [](const std::string& what, const std::string& found, const std::string& expected) {
        return "its " + what + " is \"" + found + "\", this fresco needs \"" + expected + "\": rebuild it with this fresco's SDK";
    };
    if (plugin.magic != host.magic)
        return differs("magic number", hexadecimal(plugin.magic), hexadecimal(host.magic));
    if (plugin.abi != host.abi)
        return differs("SDK ABI number", std::to_string(plugin.abi), std::to_string(host.abi));
    struct Field
    {
        const char* name;
        const char* found;
        const char* expected;
    };
    const Field fields[] = {{"compiler", plugin.compiler, host.compiler},
                            {"standard library", plugin.standard_library, host.standard_library},
                            {"kind of containers", plugin.containers, host.containers},
                            {"libtorch version", plugin.torch, torch != nullptr ? torch->torch : plugin.torch},
                            {"CUDA version", plugin.cuda, torch != nullptr ? torch->cuda : plugin.cuda}};
    const bool uses_torch = !text_of(plugin.torch).empty();
    for (const auto& field : fields)
    {
        const bool tensor_field =
            field.name == std::string_view("libtorch version") || field.name == std::string_view("CUDA version");
        if ((!tensor_field || uses_torch) && text_of(field.found) != text_of(field.expected))
            return differs(field.name, text_of(field.found), text_of(field.expected));
    }
    return std::nullopt;
}

PluginLibrary::PluginLibrary(const fs::path& file) : file_(file)
{
    // Never destroyed, so never unloaded: what a library made may be in use to the last moment of the process.
    static auto& loaded = *new std::list<boost::dll::shared_library>;
    auto* const library = &loaded.emplace_back();
    try
    {
        library->load(file.string(), boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
    }
    catch (const std::exception& error)
    {
        throw Error(loading_problem(loader_message(error.what())));
    }
    const auto info = required_symbol<fresco_plugin_info_function>(*library, FRESCO_INFO_SYMBOL)();
    const auto list_entries = required_symbol<fresco_plugin_entries_function>(*library, FRESCO_ENTRIES_SYMBOL);
    if (info == nullptr)
        throw Error("says nothing about how it was built");
    const fresco_plugin_info* torch = nullptr;
    if (const char* symbol = "fresco_sdk_torch_info_1"; library->has(symbol))
        torch = library->get<std::remove_pointer_t<fresco_plugin_info_function>>(symbol)();
    if (const auto problem = handshake_problem(*info, host_stamp(), torch))
        throw Error(*problem);

    torch_ = text_of(info->torch);
    std::size_t count = 0;
    const fresco_plugin_entry* list = list_entries(&count);
    std::set<std::string> seen;
    for (std::size_t i = 0; i < count; ++i)
    {
        const std::string type = text_of(list[i].type);
        if (list[i].what == FRESCO_ENTRY_LIBRARY)
        {
            versions_.set(type, text_of(list[i].help));
            continue;
        }
        if (!is_type_name(type) || list[i].create == nullptr)
            throw Error("registers the type \"" + type +
                        "\"; a type reads like mesh.decimate (lower case, digits, '_', dots between words)");
        if (!seen.insert(type).second)
            throw Error("registers the type \"" + type + "\" twice");
        entries_.push_back({type, text_of(list[i].kind), text_of(list[i].help)});
        makers_.push_back(list[i].create);
    }
    if (entries_.empty())
        throw Error("registers no stage and no component");
    if (!torch_.empty())
        versions_.set("libtorch", torch_);
    if (const std::string cuda = text_of(info->cuda); !cuda.empty())
        versions_.set("cuda", cuda);
    own_libraries_ = own_libraries_of(library->native(), file);
}

const PluginLibrary& PluginLibrary::open(const fs::path& file)
{
    static auto& opened = *new std::map<fs::path, const PluginLibrary*>;
    const auto known = opened.find(file);
    if (known != opened.end())
        return *known->second;
    if (const auto problem = library_file_problem(file))
        throw Error(*problem);
    return *opened.emplace(file, new PluginLibrary(file)).first->second;
}

std::unique_ptr<Configurable> PluginLibrary::make(std::string_view type) const
{
    for (std::size_t i = 0; i < entries_.size(); ++i)
    {
        if (entries_[i].type != type)
            continue;
        try
        {
            return std::unique_ptr<Configurable>(static_cast<Configurable*>(makers_[i]()));
        }
        catch (const std::bad_alloc&)
        {
            throw Error("the constructor of " + std::string(type) + " cannot be run: memory ran out");
        }
        catch (const std::exception& error)
        {
            throw Error("the constructor of " + std::string(type) + " throws: " + error.what());
        }
        catch (...)
        {
            throw Error("the constructor of " + std::string(type) + " throws something other than an exception");
        }
    }
    throw Error("holds no type \"" + std::string(type) + "\"");
}

}  // namespace fresco::host
