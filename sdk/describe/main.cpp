// fresco-describe LIBRARY: writes NAME.json beside NAME.so, the description by which `fresco` knows a plugin without opening it.
// fresco_add_plugin runs it after linking.
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/plugin_library.h>
#include <fresco/reader.h>
#include <fresco/stage.h>
#include <fresco/viewer.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>

namespace
{

namespace fs = std::filesystem;
using fresco::Value;

template <class T>
Value list_of(const std::vector<T>& all)
{
    return Value::List(all.begin(), all.end());
}

/// The object as a T where it is one. Throws Error where it is none although its kind says so.
template <class T>
const T* as(const fresco::Configurable& object, const fresco::PluginLibrary::Entry& entry, std::string_view kind,
            const char* base)
{
    const auto* made = dynamic_cast<const T*>(&object);
    if (made == nullptr && entry.kind == kind)
        throw fresco::Error("the type " + entry.type + " is registered as a " + entry.kind +
                            " but does not derive from fresco::" + base);
    return made;
}

Value describe_type(const fresco::PluginLibrary::Entry& entry, const fresco::Configurable& object)
{
    Value declaration = object.describe();
    if (const auto* stage = as<fresco::Stage>(object, entry, "stage", "Stage"))
        declaration.set("memory_mb", stage->memory_mb());
    if (const auto* origin = as<fresco::FileOrigin>(object, entry, fresco::FileOrigin::component_kind, "FileOrigin"))
        declaration.set("extensions", list_of(origin->extensions()));
    if (const auto* reader = as<fresco::FileReader>(object, entry, fresco::FileReader::component_kind, "FileReader"))
    {
        declaration.set("artifact", reader->artifact());
        declaration.set("extensions", list_of(reader->extensions()));
        Value::List formats;
        for (const fresco::FileFormat& format : reader->formats())
            formats.push_back(format.describe());
        declaration.set("formats", std::move(formats));
    }
    if (const auto* viewer = as<fresco::Viewer>(object, entry, fresco::Viewer::component_kind, "Viewer"))
    {
        declaration.set("artifact", viewer->type().name);
        declaration.set("extensions", list_of(viewer->extensions()));
    }
    return Value::Map{{"type", entry.type}, {"kind", entry.kind}, {"help", entry.help}, {"declaration", std::move(declaration)}};
}

Value describe_stamp(const fresco_plugin_info& stamp)
{
    return Value::Map{{"magic", std::int64_t{stamp.magic}},
                      {"abi", std::int64_t{stamp.abi}},
                      {"compiler", stamp.compiler},
                      {"standard_library", stamp.standard_library},
                      {"containers", stamp.containers},
                      {"torch", stamp.torch},
                      {"cuda", stamp.cuda}};
}

/// The system's package manager replaces these libraries, not the author of a plugin.
bool is_of_system(const fs::path& library)
{
    const std::vector<std::string> folders{"/lib/", "/lib64/", "/usr/lib/", "/usr/lib64/", "/usr/local/lib/"};
    return std::ranges::any_of(folders, [&](const std::string& folder) { return library.string().starts_with(folder); });
}

/// The names of the libraries that may be moved with the plugin: fresco decides by the place of each whether it belongs to it.
Value own_libraries(const fs::path& plugin)
{
    std::error_code error;
    const fs::path itself = fs::weakly_canonical(plugin, error);
    const std::vector<fs::path> folders = fresco::own_library_folders(itself);
    std::set<std::string> names;
    for (const fs::path& library : fresco::loaded_libraries())
    {
        const fs::path real = fs::weakly_canonical(library, error);
        const std::string name = library.filename().string();
        const bool is_own = name.starts_with("libfresco_") || std::ranges::count(folders, real.parent_path()) > 0;
        if ((is_own || !is_of_system(real)) && real != itself && fs::exists(real, error))
            names.insert(name);
    }
    return Value::List(names.begin(), names.end());
}

void describe(const fs::path& file)
{
    const std::string id = fresco::build_id(file);
    const fresco::PluginLibrary& plugin = fresco::PluginLibrary::open(file);
    Value::List types;
    for (const fresco::PluginLibrary::Entry& entry : plugin.entries())
        types.push_back(describe_type(entry, *plugin.make(entry.type)));
    const Value description = Value::Map{{"build_id", id},
                                         {"handshake", describe_stamp(plugin.stamp())},
                                         {"versions", plugin.versions()},
                                         {"own_libraries", own_libraries(file)},
                                         {"types", std::move(types)}};
    fresco::write_file(fs::path(file).replace_extension(".json"), to_json(description) + "\n");
}

}  // namespace

int main(int argc, char** argv)
{
    if (argc != 2)
    {
        std::fputs("usage: fresco-describe NAME.so\n    writes NAME.json beside it; fresco_add_plugin calls it\n", stderr);
        return 2;
    }
    int code = 0;
    try
    {
        describe(fs::absolute(argv[1]));
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "fresco-describe: %s: %s\n", argv[1], error.what());
        code = 1;
    }
    // Static destructors of libraries have nothing to do here that is worth a crash.
    std::_Exit(code);
}
