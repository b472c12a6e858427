#include "base/common.h"
#include "base/process.h"
#include "plugins/plugin_library.h"

#include "base/file_stamp.h"
#include "base/records.h"
#include "base/text.h"
#include "plugins/plugin_probe.h"
#include "plugins/plugin_search.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace fresco::host
{
namespace
{

constexpr int cache_format = 3;
constexpr const char* named_by_user = "FRESCO_PLUGIN_PATH";

fs::path home_based(const char* variable, const char* below_home)
{
    if (const char* folder = std::getenv(variable); folder != nullptr && *folder == '/')
        return folder;
    const char* home = std::getenv("HOME");
    return home != nullptr && *home == '/' ? fs::path(home) / below_home : fs::path();
}

/// The SDK library that this process runs with.
fs::path sdk_library()
{
    Dl_info info{};
    const auto symbol = static_cast<std::string (*)(std::string_view)>(&content_hash);
    return dladdr(reinterpret_cast<const void*>(symbol), &info) != 0 && info.dli_fname != nullptr ? fs::path(info.dli_fname)
                                                                                                  : fs::path();
}

/// A folder below /tmp, for users whose cache folder cannot be written. Empty unless it exists, or `make` makes it, and only this
/// user can write to it: descriptions decide what is loaded.
fs::path private_folder(bool make)
{
    std::error_code error;
    const fs::path folder = fs::temp_directory_path(error) / ("fresco-" + std::to_string(geteuid()));
    if (make)
        mkdir(folder.c_str(), S_IRWXU);
    struct stat status = {};
    const bool is_own = !error && lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
                        (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
    return is_own ? folder : fs::path();
}

/// A description is keyed by the contents of library and SDK and by everything that decides what the loader finds: the path,
/// LD_LIBRARY_PATH, and the names and contents of the files in the folders of fresco's own libraries.
class DescriptorCache
{
  public:
    DescriptorCache() : folders_(usable_folders()), hashes_(stamps_in(folders_)) { sdk_hash_ = hash(sdk_library()); }

    /// As it was when first asked for: in an image, where stamps are not relied on, each file is still read only once.
    std::string hash(const fs::path& file)
    {
        std::string& hash = files_[file];
        if (hash.empty())
            hash = hashes_.hash(file);
        return hash;
    }

    /// The remembered probe, or nothing where the file was never seen or a library behind it may be another.
    std::optional<Probe> find(const fs::path& library)
    {
        const auto read = [&]() -> std::optional<Probe>
        {
            const std::string key = key_of(library);
            const auto file =
                std::ranges::find_if(folders_, [&](const fs::path& folder) { return is_file(file_in(folder, key)); });
            if (file == folders_.end())
                return std::nullopt;
            const Value value = read_record(file_in(*file, key));
            const auto is_as_it_was = [&](const Value::Entry& own)
            { return fs::exists(own.first) && hash(own.first) == own.second.as_string(); };
            if (value.at("key").as_string() != key || !std::ranges::all_of(value.at("own_hashes").as_map(), is_as_it_was) ||
                value.at("own_names") != own_names(library))
                return std::nullopt;
            return Probe{library, value.at("description"), value.at("refusal").as_string(), true};
        };
        return attempt(read).value_or(std::nullopt);
    }

    void remember(const Probe& probe)
    {
        if (!probe.refusal.empty() && !probe.lasting)
            return;
        const auto write_to = [&](const fs::path& folder)
        {
            Value::Map own;
            if (probe.refusal.empty())
                for (const auto& file : probe.description.at("own_libraries").as_list())
                    own.emplace_back(file.as_string(), hash(file.as_string()));
            // It may have been replaced while it was asked.
            if (file_hash(probe.library) != hash(probe.library))
                return;
            const std::string key = key_of(probe.library);
            write_record(file_in(folder, key), Value::Map{{"key", key},
                                                          {"description", probe.description},
                                                          {"refusal", probe.refusal},
                                                          {"own_hashes", std::move(own)},
                                                          {"own_names", own_names(probe.library)}});
        };
        const auto is_written = [&](const fs::path& folder) { return attempt([&] { write_to(folder); }); };
        auto folder = std::ranges::find_if(folders_, is_written);
        const fs::path own = folder == folders_.end() ? private_folder(true) : fs::path();
        if (!own.empty() && std::ranges::count(folders_, own) == 0)
        {
            folders_.push_back(own);
            folder = std::find_if(std::prev(folders_.end()), folders_.end(), is_written);
        }
        if (std::exchange(is_told_, true) || (folder != folders_.end() && *folder == descriptor_cache_folder()))
            return;
        const fs::path wanted = descriptor_cache_folder();
        print_message("warning: " + (wanted.empty() ? "there is no cache folder" : wanted.string() + " cannot be written") +
                      (folder == folders_.end() ? ", so that each run takes seconds to find its plugins: set "
                                                : "; what plugins declare is kept in " + folder->string() + ": set ") +
                      "XDG_CACHE_HOME to a folder that can be written");
    }

    void save() { hashes_.save(); }

  private:
    std::string key_of(const fs::path& library)
    {
        const char* path = std::getenv("LD_LIBRARY_PATH");
        return std::to_string(cache_format) + "/" + std::to_string(FRESCO_ABI) + "/" + sdk_hash_ + "/" + hash(library) + "/" +
               library.string() + ":" + (path != nullptr ? path : "");
    }

    static fs::path file_in(const fs::path& folder, const std::string& key) { return folder / (content_hash(key) + ".json"); }

    static bool is_writable(const fs::path& folder) { return access(folder.c_str(), W_OK | X_OK) == 0; }

    /// The user's folder comes first. One that can only be read may hold descriptions, as in an image of a container.
    static std::vector<fs::path> usable_folders()
    {
        std::vector<fs::path> folders;
        const fs::path wanted = descriptor_cache_folder();
        const auto prepare = [&]
        {
            forbid_links_below(wanted.parent_path(), "remove it, or set another cache folder with XDG_CACHE_HOME");
            make_folder(wanted);
        };
        if (!wanted.empty() && attempt(prepare))
            folders.push_back(wanted);
        if (const fs::path own = private_folder(folders.empty() || !is_writable(wanted)); !own.empty())
            folders.push_back(own);
        return folders;
    }

    static fs::path stamps_in(const std::vector<fs::path>& folders)
    {
        const auto folder = std::ranges::find_if(folders, is_writable);
        return folder == folders.end() ? fs::path() : *folder / "stamps.json";
    }

    /// Of the libraries in the folders of fresco's own: where one is added, the loader may choose it instead of another.
    Value own_names(const fs::path& library)
    {
        Value::Map names;
        for (const fs::path& folder : own_folders(library))
        {
            std::string& hash = names_[folder];
            if (std::error_code error; hash.empty() && fs::is_directory(folder, error))
                hash = take_dependency(folder / "lib*.so*", true).hash;
            names.emplace_back(folder.string(), hash);
        }
        return names;
    }

    std::vector<fs::path> folders_;
    FileHashes hashes_;
    std::map<fs::path, std::string> files_;
    std::map<fs::path, std::string> names_;
    std::string sdk_hash_;
    bool is_told_ = false;
};

void add_to_catalog(Catalog& catalog, const Probe& probe, std::size_t place, DescriptorCache& cache)
{
    if (!probe.refusal.empty())
    {
        catalog.add(Refusal{probe.library, probe.refusal});
        return;
    }
    const auto hash_of = [&](const Value& file) { return cache.hash(file.as_string()); };
    const std::string hash =
        combined_library_hash(cache.hash(probe.library), each(probe.description.at("own_libraries").as_list(), hash_of));
    for (const auto& type : probe.description.at("types").as_list())
        catalog.add(TypeDescription{type.at("type").as_string(), type.at("kind").as_string(), type.at("help").as_string(),
                                    type.at("declaration"), probe.library, hash, probe.description.at("versions"), place});
}

/// Plugins are NAME.so; libNAME.so beside them is a library that they link, such as an artifact type of their own.
bool is_named_as_plugin(const fs::path& file)
{
    return file.extension() == ".so" && !file.filename().string().starts_with("lib");
}

/// The files of all folders that look like plugins, each once, and the place of its folder: all folders of FRESCO_PLUGIN_PATH are
/// one. What cannot be a plugin is refused at once.
std::map<fs::path, std::size_t> candidates(Catalog& catalog)
{
    std::map<fs::path, std::size_t> files;
    std::set<fs::path> seen;
    std::set<std::string> origins;
    for (const auto& folder : plugin_folders())
    {
        origins.insert(folder.origin);
        const std::size_t place = origins.size();
        std::error_code error;
        fs::directory_iterator entries(folder.path, error);
        if (error)
        {
            if (folder.origin == named_by_user)
                catalog.add(Refusal{folder.path, "FRESCO_PLUGIN_PATH names this folder: " + error.message(), true});
            continue;
        }
        std::vector<fs::path> found;
        for (const auto& entry : entries)
            if (is_named_as_plugin(entry.path()))
                found.push_back(entry.path());
        if (found.empty() && folder.origin == named_by_user)
            catalog.add(Refusal{folder.path, "FRESCO_PLUGIN_PATH names this folder, which holds no plugin (NAME.so)", true});
        std::ranges::sort(found);
        for (const auto& file : found)
        {
            const fs::path real = fs::weakly_canonical(file, error);
            if (!seen.insert(real).second)
                continue;
            if (const auto problem = library_file_problem(real))
                catalog.add(Refusal{file, *problem});
            else
                files.emplace(real, place);
        }
    }
    return files;
}

/// The plugins of fresco's own tree that are not in `folder`, by the list that the build puts there: a line for each, NAME where
/// it was to be built and NAME: REASON where it was left out. The type of mesh_decimate is mesh.decimate.
void add_unbuilt(Catalog& catalog, const fs::path& folder)
{
    std::ifstream list(folder / "plugins.txt");
    for (std::string line; std::getline(list, line);)
    {
        const std::size_t colon = std::min(line.find(": "), line.size());
        std::string type = line.substr(0, colon);
        std::error_code error;
        if (type.empty() || fs::exists(folder / (type + ".so"), error))
            continue;
        if (const std::size_t separator = type.find('_'); separator != std::string::npos)
            type[separator] = '.';
        if (catalog.libraries_of(type).empty() && !catalog.find_unbuilt(type))
            catalog.add(UnbuiltPlugin{type, colon < line.size() ? line.substr(colon + 2) : ""});
    }
}

}  // namespace

std::vector<PluginFolder> plugin_folders()
{
    std::vector<PluginFolder> folders;
    if (const char* path = std::getenv(named_by_user))
        for (const std::string& folder : split(path, ':'))
            if (!folder.empty())
                folders.push_back({fs::absolute(folder), named_by_user});
    if (const fs::path data = home_based("XDG_DATA_HOME", ".local/share"); !data.empty())
        folders.push_back({data / "fresco" / "plugins", "user"});
    if (const fs::path program = own_program(); !program.empty())
        folders.push_back({program.parent_path().parent_path() / "lib" / "fresco", "installation"});
    return folders;
}

std::vector<std::string> plugin_folder_warnings()
{
    std::vector<std::string> warnings;
    for (const PluginFolder& folder : plugin_folders())
    {
        std::error_code error;
        const fs::directory_iterator entries(folder.path, error);
        if (error && folder.origin == named_by_user)
            warnings.push_back("FRESCO_PLUGIN_PATH: " + folder.path.string() + ": " + error.message());
        else if (!error && (fs::status(folder.path, error).permissions() & fs::perms::others_write) != fs::perms::none)
            warnings.push_back(folder.path.string() +
                               ": every user may put plugins into this folder, and they run as you: chmod o-w " +
                               shell_word(folder.path.string()));
    }
    return warnings;
}

fs::path descriptor_cache_folder()
{
    const fs::path cache = home_based("XDG_CACHE_HOME", ".cache");
    return cache.empty() ? fs::path() : cache / "fresco" / "descriptors";
}

std::string combined_library_hash(const std::string& plugin_hash, const std::vector<std::string>& own_hashes)
{
    std::string joined = plugin_hash;
    for (const auto& hash : own_hashes)
        joined += "/" + hash;
    return content_hash(joined);
}

Catalog load_catalog(bool again)
{
    Catalog catalog;
    DescriptorCache cache;
    std::vector<fs::path> unknown;
    const std::map<fs::path, std::size_t> places = candidates(catalog);
    for (const auto& [file, place] : places)
    {
        try
        {
            const auto known = cache.find(file);
            if (known && (known->refusal.empty() || !again))
                add_to_catalog(catalog, *known, place, cache);
            else
                unknown.push_back(file);
        }
        catch (const Error& error)
        {
            catalog.add(Refusal{file, error.what()});
        }
    }
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    std::vector<Probe> probes = probe_plugins(unknown, cores);
    std::ranges::sort(probes, {}, &Probe::library);
    for (const auto& probe : probes)
    {
        cache.remember(probe);
        add_to_catalog(catalog, probe, places.at(probe.library), cache);
    }
    cache.save();
    for (const auto& folder : plugin_folders())
        add_unbuilt(catalog, folder.path);
    return catalog;
}

}  // namespace fresco::host
