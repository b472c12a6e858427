// Compiled into every plugin by fresco_add_plugin: the handshake's two symbols and the plugin's own list of entries.
#include <fresco/plugin.h>

#include <vector>

#ifdef FRESCO_PLUGIN_USES_TORCH
#include <torch/version.h>
#endif

namespace fresco::detail
{
namespace
{
std::vector<fresco_plugin_entry>& entries()
{
    static std::vector<fresco_plugin_entry> list;
    return list;
}
}  // namespace

Registrar::Registrar(int what, const char* type, const char* kind, const char* help, void* (*create)())
{
    entries().push_back({what, type, kind, help, create});
}
}  // namespace fresco::detail

#define FRESCO_EXPORT extern "C" __attribute__((visibility("default")))

FRESCO_EXPORT const fresco_plugin_info* fresco_plugin_info_1();
FRESCO_EXPORT const fresco_plugin_entry* fresco_plugin_entries_1(size_t* count);

const fresco_plugin_info* fresco_plugin_info_1()
{
#ifdef FRESCO_PLUGIN_USES_TORCH
    static constexpr const char* torch = TORCH_VERSION;
    static constexpr const char* cuda = FRESCO_TORCH_CUDA;
#else
    static constexpr const char* torch = "";
    static constexpr const char* cuda = "";
#endif
    static constexpr fresco_plugin_info info{
        FRESCO_MAGIC, FRESCO_ABI, FRESCO_COMPILER_STAMP, FRESCO_STANDARD_LIBRARY_STAMP, FRESCO_CONTAINERS_STAMP, torch, cuda};
    return &info;
}

const fresco_plugin_entry* fresco_plugin_entries_1(size_t* count)
{
    const auto& list = fresco::detail::entries();
    *count = list.size();
    return list.data();
}
