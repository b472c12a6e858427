#pragma once

#include <string_view>

/// \file Named points at which the proofs (tests/prove) kill a run, to show that no moment of it is a bad one. These functions do
/// nothing in fresco; the program fresco_with_faults, which is built for tests only, has others (tests/prove/kill/fault.cpp).

namespace fresco::host
{

/// Marks a moment at which a killed run leaves something behind.
void fault_point(std::string_view point);
/// Names the stage that this process works for. Its parent is the host.
void set_fault_stage(std::string_view stage);

}  // namespace fresco::host
