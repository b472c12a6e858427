#pragma once

namespace fresco::host
{

/// From now on an overflow of this thread's stack is reported to the host, as a failure in words, before the process dies of it.
/// Call it on the thread that will run the stage.
void report_stack_overflow();

}  // namespace fresco::host
