#include "worker/worker_factory.h"
#include "base/common.h"

#include <fresco/error.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

/// Result of `work` with a plugin's file. An Error becomes a PluginFailure that names the file.
template <class Work>
auto named(const std::filesystem::path& library, const Work& work)
{
    try
    {
        return work();
    }
    catch (const Error& error)
    {
        throw PluginFailure("plugin " + library.string() + ": " + error.what());
    }
}

}  // namespace

std::unique_ptr<Configurable> WorkerFactory::make(const std::string& type)
{
    const auto library = libraries_.find(type);
    if (library == libraries_.end() || identities_.find(type) == nullptr)
        throw PluginFailure("no plugin is known for the type " + type);
    return named(library->second, [&] { return open(type, library->second).make(type); });
}

void WorkerFactory::open_all()
{
    for (const auto& [type, library] : libraries_)
        open(type, library);
}

const PluginLibrary& WorkerFactory::open(const std::string& type, const std::filesystem::path& library)
{
    auto known = opened_.find(library);
    if (known == opened_.end())
        known = opened_.emplace(library, named(library, [&] { return open_plugin(library); })).first;
    const OpenPlugin& plugin = known->second;
    if (named(library, [&] { return plugin.bytes.hash(); }) != identities_.at(type).at("hash").as_string())
        throw PluginFailure("plugin " + library.string() + ": was rebuilt since the run began; run again");
    return *plugin.library;
}

std::shared_ptr<Component> WorkerFactory::create(std::string_view kind, const Value& config)
{
    const std::string identity = std::string(kind) + " " + to_json(config);
    if (const auto known = made_.find(identity); known != made_.end())
        return known->second;
    const std::string& type = config.at("type").as_string();
    const auto shared = std::dynamic_pointer_cast<Component>(std::shared_ptr<Configurable>(make(type)));
    if (shared == nullptr)
        throw PluginFailure("plugin " + libraries_.at(type).string() + ": " + type + " is not a component");
    Value::Map options = config.as_map();
    std::erase_if(options, [](const Value::Entry& entry) { return entry.first == "type"; });
    shared->configure(Value(std::move(options)), *this);
    return made_[identity] = shared;
}

Value WorkerFactory::versions() const
{
    Value all = Value::Map{};
    for (const auto& [file, plugin] : opened_)
        for (const auto& [name, version] : plugin.library->versions().as_map())
            if (all.find(name) == nullptr)
                all.set(name, version);
    return all;
}

}  // namespace fresco::host
