#pragma once

#include <fresco/abi.h>
#include <fresco/component.h>
#include <fresco/value.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file Opens plugins. fresco-describe does so once, when a plugin is built, and writes NAME.json beside NAME.so; workers do
/// when they run its stages, and tests of plugins. The program `fresco` itself reads only the descriptions.

namespace fresco
{

/// The stamp of this SDK; a plugin must have the same.
const fresco_plugin_info& sdk_stamp();

/// Says what differs between a plugin's stamp and the SDK's, with both values; nothing if they agree. `torch` is the stamp of the
/// tensor SDK that the plugin runs with, or nullptr. Ignores all fields behind the ABI number if that differs.
std::optional<std::string> handshake_problem(const fresco_plugin_info& plugin, const fresco_plugin_info& sdk,
                                             const fresco_plugin_info* torch = nullptr);

/// The ELF build id of a library, in hexadecimal: it says which build a description belongs to. Stripping the library or changing
/// its RPATH keeps it. Throws Error, without the file's name, if the file is no shared library or has none.
std::string build_id(const std::filesystem::path& library);

/// The SDK's library that this process runs with.
std::filesystem::path sdk_library();

/// The folders in which fresco's other libraries (artifact types, the tensor SDK) are found for a plugin, in the loader's order.
std::vector<std::filesystem::path> own_library_folders(const std::filesystem::path& plugin);

/// The shared libraries of this process, by the paths that the loader found them by.
std::vector<std::filesystem::path> loaded_libraries();

/// Whether a stage or component can be called so: small letters, digits and '_', in words with dots between them.
bool is_type_name(const std::string& type);

/// An open plugin. It stays open until the process ends: libtorch does not survive being unloaded.
class PluginLibrary
{
  public:
    /// Opens it (once per process) and shakes hands. Throws Error with the reason, without the file's name. A bad file may crash
    /// or hang the process.
    static const PluginLibrary& open(const std::filesystem::path& file);

    struct Entry
    {
        std::string type;
        std::string kind;
        std::string help;
        void* (*create)();
    };
    const std::vector<Entry>& entries() const { return entries_; }
    /// The stamp that the plugin was built with.
    const fresco_plugin_info& stamp() const { return *stamp_; }
    /// Map name -> version of the libraries behind the plugin.
    const Value& versions() const { return versions_; }

    /// A new object of a type it holds. Throws Error if its constructor throws or it holds no such type.
    std::unique_ptr<Configurable> make(std::string_view type) const;

  private:
    explicit PluginLibrary(const std::filesystem::path& file);

    std::vector<Entry> entries_;
    const fresco_plugin_info* stamp_ = nullptr;
    Value versions_{Value::Map{}};
};

}  // namespace fresco
