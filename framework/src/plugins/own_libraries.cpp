#include "plugins/own_libraries.h"

#include <algorithm>
#include <dlfcn.h>
#include <link.h>
#include <set>
#include <string>
#include <unistd.h>

namespace fresco::host
{
namespace fs = std::filesystem;
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

}  // namespace

std::set<fs::path> own_folders(const fs::path& library)
{
    std::error_code error;
    return {fs::weakly_canonical(library.parent_path(), error), fs::weakly_canonical(library.parent_path() / "..", error),
            fs::weakly_canonical(program_folder() / ".." / "lib", error)};
}

fs::path program_folder()
{
    char target[4096];
    const ssize_t length = readlink("/proc/self/exe", target, sizeof target);
    return length > 0 ? fs::path(std::string(target, static_cast<std::size_t>(length))).parent_path() : fs::path();
}

std::vector<fs::path> own_libraries_of(void* handle, const fs::path& library)
{
    link_map* own = nullptr;
    if (dlinfo(handle, RTLD_DI_LINKMAP, &own) != 0 || own == nullptr)
        return {};
    const link_map* first = own;
    while (first->l_prev != nullptr)
        first = first->l_prev;

    std::set<const link_map*> seen{own};
    std::vector<const link_map*> open{own};
    while (!open.empty())
    {
        const link_map* current = open.back();
        open.pop_back();
        for (const auto& name : needed_by(*current))
            for (const link_map* other = first; other != nullptr; other = other->l_next)
                if (fs::path(other->l_name).filename() == fs::path(name).filename() && seen.insert(other).second)
                    open.push_back(other);
    }
    seen.erase(own);

    std::error_code error;
    const std::set<fs::path> folders = own_folders(library);
    std::vector<fs::path> result;
    for (const link_map* entry : seen)
    {
        const fs::path file = fs::weakly_canonical(entry->l_name, error);
        if (file.filename().string().starts_with("libfresco_") || folders.count(file.parent_path()) != 0)
            result.push_back(file);
    }
    std::sort(result.begin(), result.end());
    return result;
}

}  // namespace fresco::host
