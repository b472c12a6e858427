// Built by another compiler.
#include <fresco/abi.h>
#include <fresco/plugin.h>

extern "C"
{
    __attribute__((visibility("default"))) const fresco_plugin_info* fresco_plugin_info_1();
    __attribute__((visibility("default"))) const fresco_plugin_entry* fresco_plugin_entries_1(size_t* count);
}

const fresco_plugin_info* fresco_plugin_info_1()
{
    static constexpr fresco_plugin_info info{
        FRESCO_MAGIC, FRESCO_ABI, "gcc 4", FRESCO_STANDARD_LIBRARY_STAMP, FRESCO_CONTAINERS_STAMP, "", ""};
    return &info;
}

const fresco_plugin_entry* fresco_plugin_entries_1(size_t* count)
{
    *count = 0;
    return nullptr;
}
