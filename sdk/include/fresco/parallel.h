#pragma once

#include <cstddef>
#include <functional>

namespace fresco
{

/// Calls `work(begin, end)` for pieces of [0, count) of at most `grain` items on up to `threads` threads. The pieces depend on
/// `count` and `grain` alone, never on `threads`, so that per-piece results summed in order are the same for any thread count.
/// The first exception (by piece) is rethrown after all threads have ended. Blocks until done.
void parallel_for(std::size_t count, std::size_t grain, int threads, const std::function<void(std::size_t, std::size_t)>& work);

}  // namespace fresco
