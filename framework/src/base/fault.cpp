#include "base/fault.h"

namespace fresco::host
{

void set_fault_stage(std::string_view /*stage*/) {}
void fault_point(std::string_view /*point*/) {}

}  // namespace fresco::host
