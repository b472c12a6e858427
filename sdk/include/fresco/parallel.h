#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

/// \file How stages use the threads that the host gives them, with the same bytes for any number of threads.

namespace fresco
{

class Progress;

/// Calls `work(begin, end)` for pieces of [0, count) of at most `grain` items on up to `threads` threads. The pieces depend
/// only on `count` and `grain`, never on `threads`, so that per-piece results summed in order are the same for any thread count.
/// The first exception (by piece) is rethrown after all threads have ended. Blocks until done.
void parallel_for(std::size_t count, std::size_t grain, int threads, const std::function<void(std::size_t, std::size_t)>& work);

/// Calls `work(i)` for each item as parallel_for does, one by one, on progress.threads() threads. Looks for cancelation before
/// each and reports afterward how many are done, in `unit` ("views").
void parallel_for_each(std::size_t count, std::string_view unit, Progress& progress,
                       const std::function<void(std::size_t)>& work);

}  // namespace fresco
