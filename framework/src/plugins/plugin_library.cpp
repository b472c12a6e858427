#include "plugins/plugin_library.h"
#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/plugin.h>

#include <algorithm>
#include <boost/dll/shared_library.hpp>
#include <cerrno>
#include <cstring>
#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <link.h>
#include <list>
#include <map>
#include <new>
#include <sys/resource.h>
#include <sys/stat.h>
#include <tuple>
#include <unistd.h>

#define BOOST_DLL_USE_STD_FS

namespace fresco::host
{

namespace
{

std::vector<std::string> needed_by(const link_map& library)
{
    const char* strings = nullptr;
    for (const ElfW(Dyn)* entry = library.l_ld; entry->d_tag != DT_NULL; ++entry)
        if (entry->d_tag == DT_STRTAB)
        {
            // The loader adds the base address on most machines, not on all.
            const auto address = entry->d_un.d_ptr;
            strings = reinterpret_cast<const char*>(address < library.l_addr ? library.l_addr + address : address);
        }
    std::vector<std::string> names;
    if (strings != nullptr)
        for (const ElfW(Dyn)* entry = library.l_ld; entry->d_tag != DT_NULL; ++entry)
            if (entry->d_tag == DT_NEEDED)
                names.emplace_back(strings + entry->d_un.d_val);
    return names;
}

const char* kind_of(mode_t mode)
{
    for (const auto& [kind, name] : {std::pair(S_IFDIR, "a folder"),
                                     {S_IFIFO, "a FIFO"},
                                     {S_IFSOCK, "a socket"},
                                     {S_IFCHR, "a device"},
                                     {S_IFBLK, "a device"}})
        if ((mode & S_IFMT) == static_cast<mode_t>(kind))
            return name;
    return "no regular file";
}

template <class T>
bool read_at(int fd, std::uint64_t offset, T& into)
{
    return pread(fd, &into, sizeof into, static_cast<off_t>(offset)) == static_cast<ssize_t>(sizeof into);
}

std::string cut_short(std::uint64_t needed, std::uint64_t size)
{
    return "is cut short: its headers speak of " + std::to_string(needed) + " bytes, it has " + std::to_string(size);
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

std::set<fs::path> own_folders(const fs::path& library)
{
    std::error_code error;
    return {fs::weakly_canonical(library.parent_path(), error), fs::weakly_canonical(library.parent_path() / "..", error),
            fs::weakly_canonical(own_program().parent_path() / ".." / "lib", error)};
}

namespace
{

/// Of the libraries that an open library needs, directly or not, those that belong to fresco. `handle` is what dlopen gave.
std::vector<fs::path> own_libraries_of(void* handle, const fs::path& library)
{
    link_map* own = nullptr;
    if (dlinfo(handle, RTLD_DI_LINKMAP, &own) != 0 || own == nullptr)
        return {};
    const link_map* first = own;
    while (first->l_prev != nullptr)
        first = first->l_prev;
    // libtorch brings hundreds of libraries.
    const auto file_name = [](std::string_view path) { return path.substr(path.rfind('/') + 1); };
    std::multimap<std::string_view, const link_map*> loaded;
    for (const link_map* each = first; each != nullptr; each = each->l_next)
        loaded.emplace(file_name(each->l_name), each);
    std::set<const link_map*> seen{own};
    std::vector<const link_map*> open{own};
    while (!open.empty())
    {
        const link_map* current = open.back();
        open.pop_back();
        for (const auto& name : needed_by(*current))
            for (auto [other, end] = loaded.equal_range(file_name(name)); other != end; ++other)
                if (seen.insert(other->second).second)
                    open.push_back(other->second);
    }
    seen.erase(own);
    std::error_code error;
    const std::set<fs::path> folders = own_folders(library);
    std::vector<fs::path> result;
    for (const link_map* entry : seen)
    {
        const fs::path file = fs::weakly_canonical(entry->l_name, error);
        if (file.filename().string().starts_with("libfresco_") || folders.contains(file.parent_path()))
            result.push_back(file);
    }
    std::ranges::sort(result);
    return result;
}

}  // namespace

std::optional<std::string> library_file_problem(const std::filesystem::path& file)
{
    struct stat status = {};
    if (stat(file.c_str(), &status) != 0)
        return std::string("cannot be looked at: ") + std::strerror(errno);
    if (!S_ISREG(status.st_mode))
        return std::string("is ") + kind_of(status.st_mode) + ", not a shared library";
    const FileDescriptor fd(uninterrupted([&] { return open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); }));
    if (!fd.valid())
        return std::string("cannot be opened: ") + std::strerror(errno);
    const auto size = static_cast<std::uint64_t>(status.st_size);
    Elf64_Ehdr header{};
    Elf64_Ehdr own{};
    if (size < SELFMAG)
        return "is not a shared library: it has " + std::to_string(size) + " bytes";
    if (!read_at(fd.get(), 0, header))
    {
        char magic[SELFMAG] = {};
        const bool elf = read_at(fd.get(), 0, magic) && std::memcmp(magic, ELFMAG, SELFMAG) == 0;
        return elf ? cut_short(sizeof header, size) : "is not a shared library: it does not begin as an ELF file";
    }
    if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
        return "is not a shared library: it does not begin as an ELF file";
    const FileDescriptor program(uninterrupted([&] { return open("/proc/self/exe", O_RDONLY | O_CLOEXEC); }));
    if (read_at(program.get(), 0, own) && (header.e_ident[EI_CLASS] != own.e_ident[EI_CLASS] ||
                                           header.e_ident[EI_DATA] != own.e_ident[EI_DATA] || header.e_machine != own.e_machine))
        return "is made for another kind of machine (ELF machine " + std::to_string(header.e_machine) + ", this one is " +
               std::to_string(own.e_machine) + ")";
    if (header.e_type != ET_DYN)
        return "is not a shared library (ELF type " + std::to_string(header.e_type) + ")";
    const std::uint64_t sections_end = header.e_shoff + std::uint64_t{header.e_shentsize} * header.e_shnum;
    if (header.e_shoff != 0 && (sections_end < header.e_shoff || sections_end > size))
        return cut_short(sections_end, size);
    for (std::uint64_t i = 0; i < header.e_phnum; ++i)
    {
        Elf64_Phdr segment{};
        const std::uint64_t offset = header.e_phoff + i * sizeof segment;
        if (!read_at(fd.get(), offset, segment))
            return cut_short(offset + sizeof segment, size);
        if (segment.p_type == PT_LOAD && (segment.p_offset > size || segment.p_filesz > size - segment.p_offset))
            return cut_short(segment.p_offset + segment.p_filesz, size);
    }
    return std::nullopt;
}

bool is_type_name(const std::string& type)
{
    const bool is_spelled = type.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == std::string::npos;
    return is_spelled && !type.empty() && !type.starts_with('.') && !type.ends_with('.') && type.find("..") == std::string::npos;
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
        return differs("magic number", fmt::format("0x{:08X}", plugin.magic), fmt::format("0x{:08X}", host.magic));
    if (plugin.abi != host.abi)
        return differs("SDK ABI number", std::to_string(plugin.abi), std::to_string(host.abi));
    // What does not use tensors runs with any.
    const fresco_plugin_info& tensors = torch == nullptr || text_of(plugin.torch).empty() ? plugin : *torch;
    for (const auto& [what, found, expected] : {std::tuple("compiler", plugin.compiler, host.compiler),
                                                {"standard library", plugin.standard_library, host.standard_library},
                                                {"kind of containers", plugin.containers, host.containers},
                                                {"libtorch version", plugin.torch, tensors.torch},
                                                {"CUDA version", plugin.cuda, tensors.cuda}})
        if (text_of(found) != text_of(expected))
            return differs(what, text_of(found), text_of(expected));
    return std::nullopt;
}

PluginLibrary::PluginLibrary(const fs::path& file)
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

    std::size_t count = 0;
    const fresco_plugin_entry* list = list_entries(&count);
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
        if (std::ranges::find(entries_, type, &Entry::type) != entries_.end())
            throw Error("registers the type \"" + type + "\" twice");
        entries_.push_back({type, text_of(list[i].kind), text_of(list[i].help), list[i].create});
    }
    if (entries_.empty())
        throw Error("registers no stage and no component");
    for (const auto& [library_name, version] : {std::pair("libtorch", info->torch), {"cuda", info->cuda}})
        if (!text_of(version).empty())
            versions_.set(library_name, version);
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
    const auto entry = std::ranges::find(entries_, type, &Entry::type);
    if (entry == entries_.end())
        throw Error("holds no type \"" + std::string(type) + "\"");
    const std::string constructor = "the constructor of " + entry->type;
    try
    {
        return std::unique_ptr<Configurable>(static_cast<Configurable*>(entry->create()));
    }
    catch (const std::bad_alloc&)
    {
        throw Error(constructor + " cannot be run: memory ran out");
    }
    catch (const std::exception& error)
    {
        throw Error(constructor + " throws: " + error.what());
    }
    catch (...)
    {
        throw Error(constructor + " throws something other than an exception");
    }
}

}  // namespace fresco::host
