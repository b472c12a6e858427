#define BOOST_DLL_USE_STD_FS

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/plugin.h>
#include <fresco/plugin_library.h>

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
#include <tuple>
#include <type_traits>
#include <unistd.h>
#include <utility>

namespace fresco
{
namespace fs = std::filesystem;
namespace
{

template <class T>
bool read_at(int fd, std::uint64_t offset, T* into, std::size_t count = 1)
{
    const auto size = static_cast<ssize_t>(count * sizeof(T));
    return pread(fd, into, count * sizeof(T), static_cast<off_t>(offset)) == size;
}

/// The build id in the contents of a segment of notes; empty if there is none.
std::string build_id_in(const std::vector<char>& notes)
{
    constexpr std::size_t alignment = 4;
    const auto padded = [](std::size_t size) { return (size + alignment - 1) / alignment * alignment; };
    Elf64_Nhdr header{};
    for (std::size_t at = 0; notes.size() - at >= sizeof header;)
    {
        std::memcpy(&header, notes.data() + at, sizeof header);
        at += sizeof header;
        const std::size_t name_size = padded(header.n_namesz);
        if (name_size > notes.size() - at || header.n_descsz > notes.size() - at - name_size)
            return "";
        const std::string_view name(notes.data() + at, header.n_namesz);
        at += name_size;
        if (header.n_type == NT_GNU_BUILD_ID && name == std::string_view("GNU", 4))
        {
            const std::string_view id(notes.data() + at, header.n_descsz);
            return fmt::format("{:02x}", fmt::join(std::vector<unsigned char>(id.begin(), id.end()), ""));
        }
        at += std::min(padded(header.n_descsz), notes.size() - at);
    }
    return "";
}

std::string text_of(const char* text)
{
    return text != nullptr ? text : "";
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

const fresco_plugin_info& sdk_stamp()
{
    static constexpr fresco_plugin_info stamp{
        FRESCO_MAGIC, FRESCO_ABI, FRESCO_COMPILER_STAMP, FRESCO_STANDARD_LIBRARY_STAMP, FRESCO_CONTAINERS_STAMP, "", ""};
    return stamp;
}

std::optional<std::string> handshake_problem(const fresco_plugin_info& plugin, const fresco_plugin_info& sdk,
                                             const fresco_plugin_info* torch)
{
    const auto differs = [](const std::string& what, const std::string& found, const std::string& expected) {
        return "its " + what + " is \"" + found + "\", this fresco needs \"" + expected + "\": rebuild it with this fresco's SDK";
    };
    if (plugin.magic != sdk.magic)
        return differs("magic number", fmt::format("0x{:08X}", plugin.magic), fmt::format("0x{:08X}", sdk.magic));
    if (plugin.abi != sdk.abi)
        return differs("SDK ABI number", std::to_string(plugin.abi), std::to_string(sdk.abi));
    // A plugin without tensors runs with any.
    const fresco_plugin_info& tensors = torch == nullptr || text_of(plugin.torch).empty() ? plugin : *torch;
    for (const auto& [what, found, expected] : {std::tuple("compiler", plugin.compiler, sdk.compiler),
                                                {"standard library", plugin.standard_library, sdk.standard_library},
                                                {"kind of containers", plugin.containers, sdk.containers},
                                                {"libtorch version", plugin.torch, tensors.torch},
                                                {"CUDA version", plugin.cuda, tensors.cuda}})
        if (text_of(found) != text_of(expected))
            return differs(what, text_of(found), text_of(expected));
    return std::nullopt;
}

std::string build_id(const fs::path& library)
{
    // A FIFO must not block.
    const FileDescriptor file(open(library.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!file.valid())
        throw Error(std::string("cannot be opened: ") + std::strerror(errno));
    Elf64_Ehdr header{};
    constexpr unsigned char byte_order = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? ELFDATA2LSB : ELFDATA2MSB;
    if (!read_at(file.get(), 0, &header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
        header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_ident[EI_DATA] != byte_order || header.e_type != ET_DYN)
        throw Error("is not a shared library for this kind of machine (ELF, 64 bits)");
    for (std::uint64_t i = 0; i < header.e_phnum; ++i)
    {
        constexpr std::uint64_t most_bytes = 1U << 16U;
        Elf64_Phdr segment{};
        if (header.e_phentsize != sizeof segment || !read_at(file.get(), header.e_phoff + i * sizeof segment, &segment))
            throw Error("is damaged: its list of segments cannot be read");
        if (segment.p_type != PT_NOTE || segment.p_filesz > most_bytes)
            continue;
        std::vector<char> notes(segment.p_filesz);
        if (!read_at(file.get(), segment.p_offset, notes.data(), notes.size()))
            throw Error("is cut short: its notes cannot be read");
        if (std::string id = build_id_in(notes); !id.empty())
            return id;
    }
    throw Error("has no ELF build id: build it with fresco_add_plugin, which links with -Wl,--build-id");
}

fs::path sdk_library()
{
    Dl_info info{};
    std::error_code error;
    const bool is_known = dladdr(reinterpret_cast<const void*>(&sdk_stamp), &info) != 0 && info.dli_fname != nullptr;
    return is_known ? fs::weakly_canonical(info.dli_fname, error) : fs::path();
}

std::vector<fs::path> own_library_folders(const fs::path& plugin)
{
    std::error_code error;
    const fs::path folder = plugin.parent_path();
    std::vector<fs::path> folders;
    for (const fs::path& each : {folder / "../lib", folder, folder / "..", sdk_library().parent_path()})
        folders.push_back(fs::weakly_canonical(each, error));
    return folders;
}

std::vector<fs::path> loaded_libraries()
{
    std::vector<fs::path> libraries;
    const auto add = [](dl_phdr_info* info, std::size_t, void* list)
    {
        if (info->dlpi_name != nullptr && *info->dlpi_name != '\0')
            static_cast<std::vector<fs::path>*>(list)->emplace_back(info->dlpi_name);
        return 0;
    };
    dl_iterate_phdr(add, &libraries);
    return libraries;
}

PluginLibrary::PluginLibrary(const fs::path& file)
{
    // Never destroyed, so never unloaded: what a library made may be in use to the last moment of the process.
    static auto& loaded = *new std::list<boost::dll::shared_library>;
    auto* const library = &loaded.emplace_back();
    try
    {
        library->load(file, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
    }
    catch (const std::exception& error)
    {
        // Only the loader's own words, without Boost's frame around them.
        std::string text = error.what();
        const std::string_view before = "dlerror system message: ";
        if (const auto begin = text.find(before); begin != std::string::npos)
            text = text.substr(begin + before.size(), text.rfind("): ") - begin - before.size());
        throw Error("cannot be loaded: " + text);
    }
    stamp_ = required_symbol<fresco_plugin_info_function>(*library, FRESCO_INFO_SYMBOL)();
    const auto list_entries = required_symbol<fresco_plugin_entries_function>(*library, FRESCO_ENTRIES_SYMBOL);
    if (stamp_ == nullptr)
        throw Error("says nothing about how it was built");
    const fresco_plugin_info* torch = nullptr;
    if (const char* symbol = "fresco_sdk_torch_info_1"; library->has(symbol))
        torch = library->get<std::remove_pointer_t<fresco_plugin_info_function>>(symbol)();
    if (const auto problem = handshake_problem(*stamp_, sdk_stamp(), torch))
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
    for (const auto& [name, version] : {std::pair("libtorch", stamp_->torch), {"cuda", stamp_->cuda}})
        if (!text_of(version).empty())
            versions_.set(name, version);
}

bool is_type_name(const std::string& type)
{
    const bool is_spelled = type.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == std::string::npos;
    return is_spelled && !type.empty() && !type.starts_with('.') && !type.ends_with('.') && type.find("..") == std::string::npos;
}

const PluginLibrary& PluginLibrary::open(const fs::path& file)
{
    static auto& opened = *new std::map<fs::path, const PluginLibrary*>;
    const auto known = opened.find(file);
    return known != opened.end() ? *known->second : *opened.emplace(file, new PluginLibrary(file)).first->second;
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
    catch (const std::exception& error)
    {
        throw Error(constructor + " throws: " + error.what());
    }
    catch (...)
    {
        throw Error(constructor + " throws something other than an exception");
    }
}

}  // namespace fresco
