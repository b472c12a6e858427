#include "pipeline/pipeline_device.h"

namespace fresco::host
{

std::string device_option(const TypeDescription& type)
{
    const Value* cost = type.declaration.find("cost");
    const Value* option = cost ? cost->find("device") : nullptr;
    return option ? option->as_string() : "";
}

void settle_device(const TypeDescription& type, Value& options, bool (*machine_has_gpu)())
{
    if (Value* device = options.find(device_option(type)); device && *device == Value("auto"))
        *device = type.library_versions.find("cuda") && machine_has_gpu() ? "cuda" : "cpu";
}

bool works_on_gpu(const PipelineStage& stage)
{
    const Value* device = stage.options->find(device_option(*stage.type));
    return device && (*device == Value("cuda") || *device == Value(true));
}

}  // namespace fresco::host
