// What this library was built as, for the host's handshake: a plugin that speaks tensors must have been built with the same.
#include <fresco/abi.h>
#include <fresco/plugin.h>

#include <torch/version.h>

extern "C" __attribute__((visibility("default"))) const fresco_plugin_info* fresco_sdk_torch_info_1();

const fresco_plugin_info* fresco_sdk_torch_info_1()
{
    static constexpr fresco_plugin_info info{
        FRESCO_MAGIC,  FRESCO_ABI,       FRESCO_COMPILER_STAMP, FRESCO_STANDARD_LIBRARY_STAMP, FRESCO_CONTAINERS_STAMP,
        TORCH_VERSION, FRESCO_TORCH_CUDA};
    return &info;
}
