#pragma once

#include "plugins/catalog.h"
#include <fresco/configurable.h>

#include <memory>
#include <string>
#include <string_view>

namespace fresco::host
{

/// The one stage that is in no plugin: any program. A pipeline declares its ports (sdk/docs/commands.md).
inline constexpr std::string_view command_type_name = "command";

/// Its description as a plugin's would be, without ports.
TypeDescription command_type();

/// For the worker: gets its ports when it is configured.
std::unique_ptr<Configurable> make_command_stage();

}  // namespace fresco::host
