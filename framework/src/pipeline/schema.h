#pragma once

#include "plugins/catalog.h"
#include <fresco/value.h>

/// \file Lets editors complete and check pipeline files as they are written.

namespace fresco::host
{

/// A JSON Schema (2020-12) of pipeline files for editors, made from what the catalog's types declare: names of types, options
/// with their ranges, choices, defaults and help, ports, and which component fits where. `${var}` is accepted wherever a value
/// is. Throws Error where a plugin's description is not of the documented form.
Value pipeline_schema(const Catalog& catalog);

}  // namespace fresco::host
