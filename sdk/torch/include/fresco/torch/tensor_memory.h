#pragma once

#include <cstddef>

namespace fresco
{

/// From now on large tensors on the CPU get their memory from pages that earlier tensors have left, whatever their sizes were:
/// what the process holds is what its tensors held at most at one time, plus at most 2 MB for each. Otherwise it is the
/// allocator's choice between holes that no later tensor fits in and giving pages back, which then have to be cleared again.
/// For the whole process; once is enough. Any thread. Does nothing where the system cannot move pages (not Linux).
void reuse_tensor_memory();

/// Bytes that the pages take which reuse_tensor_memory() manages, in use or waiting.
std::size_t reused_tensor_bytes();

}  // namespace fresco
