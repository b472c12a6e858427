#pragma once

#include "pipeline/pipeline.h"

#include <string>

namespace fresco::host
{

/// The option that says where stages of the type work (Cost::device); empty: they have none.
std::string device_option(const TypeDescription& type);

/// Puts "cuda" or "cpu" in place of "auto" in that option: "cuda" where the plugin was built for a GPU and the machine has one,
/// which is asked only then.
void settle_device(const TypeDescription& type, Value& options, bool (*machine_has_gpu)());

/// Whether the stage works on a GPU, by its settled options.
bool works_on_gpu(const PipelineStage& stage);

}  // namespace fresco::host
