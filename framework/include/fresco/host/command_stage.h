#pragma once

#include <fresco/configurable.h>
#include <fresco/host/catalog.h>

#include <memory>
#include <string>
#include <string_view>

namespace fresco::host
{

struct PipelineStage;

/// The one stage that is in no plugin: any program. A pipeline declares its ports (sdk/docs/commands.md).
inline constexpr std::string_view command_type_name = "command";

/// Its description as a plugin's would be, without ports.
TypeDescription command_type();

/// What the costs of a stage are remembered by: its type, and of a command the program with its first words and files, too.
std::string cost_name(const PipelineStage& stage);

/// For the worker: gets its ports when it is configured.
std::unique_ptr<Configurable> make_command_stage();

}  // namespace fresco::host
