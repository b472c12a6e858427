#pragma once

#include <string_view>

/// \file Named points at which the proofs (tests/prove) make the program fail or die, to show that no moment of a run is a
/// bad one.

namespace fresco::host
{

/// For tests of what a killed run leaves behind: where the environment variable FRESCO_FAULT is "POINT" or "POINT@STAGE", the
/// process that comes by this point kills the host and itself with SIGKILL. Nothing happens otherwise.
void fault_point(std::string_view point);
/// The stage this process works for, for "POINT@STAGE"; and whether its parent is a host to be killed with it.
void set_fault_stage(std::string_view stage);

}  // namespace fresco::host
