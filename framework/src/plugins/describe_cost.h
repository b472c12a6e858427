#pragma once

#include <fresco/cost.h>
#include <fresco/value.h>

#include <string>

namespace fresco::host
{

/// A cost as the entry `cost` of TypeDescription::declaration; `options` is the entry beside it. Throws Error naming the
/// type where it names an option that is not there or is of the wrong kind, and where a number is negative or not finite.
Value describe_cost(const std::string& type, const Cost& cost, const Value& options);

}  // namespace fresco::host
