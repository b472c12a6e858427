#pragma once

#include <fresco/abi.h>
#include <fresco/component.h>
#include <fresco/value.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

/// \file Opens a plugin, after it has been compared with the host. The process that asks a plugin what it holds, and workers,
/// do; the host itself never does.

namespace fresco::host
{

/// Where libraries lie that belong to fresco: the library's folder, the folder above it, and the installation's lib folder.
/// Canonical.
std::set<std::filesystem::path> own_folders(const std::filesystem::path& library);

/// What this program was built as; a plugin must say the same.
const fresco_plugin_info& host_stamp();

/// What differs between a plugin's stamp and the host's, with both values; nothing if they agree. `torch` is the stamp of the
/// tensor SDK that the plugin runs with, or nullptr. Looks at no field behind the ABI number if that differs.
std::optional<std::string> handshake_problem(const fresco_plugin_info& plugin, const fresco_plugin_info& host,
                                             const fresco_plugin_info* torch);

/// Why the file cannot be a whole shared library for this machine, judged by its headers, or nothing. Never blocks: a FIFO, a
/// folder or a device is named, not opened.
std::optional<std::string> library_file_problem(const std::filesystem::path& file);

/// Whether a stage or component can be called so: small letters, digits and '_', in words with dots between them.
bool is_type_name(const std::string& type);

/// An open plugin. It stays open until the process ends: libtorch does not survive being unloaded.
class PluginLibrary
{
  public:
    /// Opens it (once per process) and shakes hands. Throws Error with the reason. May crash or hang with a bad file: files that
    /// were never seen are opened in a child first.
    static const PluginLibrary& open(const std::filesystem::path& file);

    struct Entry
    {
        std::string type;
        std::string kind;
        std::string help;
        void* (*create)();
    };
    const std::vector<Entry>& entries() const { return entries_; }
    /// Map name -> version of the libraries behind the plugin.
    const Value& versions() const { return versions_; }
    /// fresco's own libraries that it runs with (the SDK, artifact types): named libfresco_*, or in own_folders. Sorted.
    const std::vector<std::filesystem::path>& own_libraries() const { return own_libraries_; }

    /// A new object of a type it holds. Throws Error if its constructor throws or it holds no such type.
    std::unique_ptr<Configurable> make(std::string_view type) const;

  private:
    explicit PluginLibrary(const std::filesystem::path& file);

    std::vector<Entry> entries_;
    Value versions_{Value::Map{}};
    std::vector<std::filesystem::path> own_libraries_;
};

}  // namespace fresco::host
