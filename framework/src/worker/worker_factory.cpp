#include "worker/worker_factory.h"
#include "base/common.h"

#include "plugins/plugin_search.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

/// The same for configurations that differ only in the order of their keys.
Value sorted(const Value& value)
{
    if (value.is_list())
    {
        return each<Value>(value.as_list(), sorted);
    }
    if (!value.is_map())
        return value;
    Value::Map map;
    for (const auto& [key, entry] : value.as_map())
        map.emplace_back(key, sorted(entry));
    std::sort(map.begin(), map.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    return map;
}

}  // namespace

WorkerFactory::~WorkerFactory() = default;

std::unique_ptr<Configurable> WorkerFactory::make(const std::string& type, std::string_view kind)
{
    const auto library = libraries_.find(type);
    if (library == libraries_.end())
        throw PluginFailure("no plugin is known for the type " + type);
    try
    {
        const PluginLibrary& plugin = open(type, library->second);
        for (const auto& entry : plugin.entries())
            if (entry.type == type && entry.kind != kind)
                throw PluginFailure("a " + std::string(kind) + " is needed, " + type + " is a " + entry.kind);
        return plugin.make(type);
    }
    catch (const Error& error)
    {
        throw PluginFailure("plugin " + library->second.string() + ": " + error.what());
    }
}

const PluginLibrary& WorkerFactory::open(const std::string& type, const std::filesystem::path& library)
{
    const PluginLibrary& plugin = PluginLibrary::open(library);
    opened_[library.string()] = &plugin;
    check_unchanged(type, plugin);
    return plugin;
}

void WorkerFactory::open_all()
{
    for (const auto& [type, library] : libraries_)
        try
        {
            open(type, library);
        }
        catch (const Error& error)
        {
            throw PluginFailure("plugin " + library.string() + ": " + error.what());
        }
}

void WorkerFactory::check_unchanged(const std::string& type, const PluginLibrary& plugin)
{
    const Value* expected = identities_.find(type);
    if (expected == nullptr)
        throw PluginFailure("the type " + type + " is not among those that the result is named by");
    std::string& hash = hashes_[plugin.file().string()];
    if (hash.empty())
    {
        const std::vector<std::string> own = each<std::string>(plugin.own_libraries(), file_hash);
        hash = combined_library_hash(file_hash(plugin.file()), own);
    }
    if (hash != expected->at("hash").as_string())
        throw PluginFailure("plugin " + plugin.file().string() + ": was rebuilt since the run began; run again");
}

std::shared_ptr<Component> WorkerFactory::create(std::string_view kind, const Value& config)
{
    const std::string identity = std::string(kind) + " " + to_json(sorted(config));
    if (const auto known = made_.find(identity); known != made_.end())
        return known->second;
    const std::string& type = config.at("type").as_string();
    std::unique_ptr<Configurable> object = make(type, kind);
    auto* component = dynamic_cast<Component*>(object.get());
    if (component == nullptr)
        throw PluginFailure("plugin " + libraries_.at(type).string() + ": " + type + " is not a component");
    std::shared_ptr<Component> shared(component);
    (void)object.release();
    Value::Map options = config.as_map();
    std::erase_if(options, [](const Value::Entry& entry) { return entry.first == "type"; });
    shared->configure(Value(std::move(options)), *this);
    return made_.emplace(identity, std::move(shared)).first->second;
}

Value WorkerFactory::versions() const
{
    Value::Map all;
    for (const auto& [file, plugin] : opened_)
        for (const auto& [name, version] : plugin->versions().as_map())
            if (std::none_of(all.begin(), all.end(), [&, n = name](const Value::Entry& entry) { return entry.first == n; }))
                all.emplace_back(name, version);
    return all;
}

}  // namespace fresco::host
