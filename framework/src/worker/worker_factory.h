#pragma once

#include "plugins/plugin_library.h"
#include <fresco/component.h>

#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

/// \file Makes stages and components out of plugins, in a worker and in the process that makes a page.

namespace fresco::host
{

/// A plugin that was fine when the pipeline was checked and is not now.
class PluginFailure : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

/// Makes a stage and its components from the plugins that the host found. Equal configurations give one object.
class WorkerFactory final : public ComponentFactory
{
  public:
    /// `identities` is the key document's map of libraries: a plugin that was rebuilt since is refused. Both have all types
    /// that are asked for.
    WorkerFactory(std::map<std::string, std::filesystem::path> libraries, Value identities)
        : libraries_(std::move(libraries)), identities_(std::move(identities))
    {
    }

    std::shared_ptr<Component> create(std::string_view kind, const Value& config) override;
    /// An object that is not configured yet. Throws PluginFailure naming the file.
    std::unique_ptr<Configurable> make(const std::string& type);
    /// Opens every library, and with it the artifact types that it has. Throws PluginFailure naming the file.
    void open_all();
    /// Versions of the libraries behind all plugins opened so far.
    Value versions() const;

  private:
    /// Throws PluginFailure, also where the plugin is not the one that the result is named by.
    const PluginLibrary& open(const std::string& type, const std::filesystem::path& library);

    std::map<std::string, std::filesystem::path> libraries_;
    Value identities_;
    std::map<std::string, std::shared_ptr<Component>> made_;
    std::map<std::filesystem::path, OpenPlugin> opened_;
};

}  // namespace fresco::host
