#pragma once

#include <fresco/parallel.h>

#include <concepts>
#include <cstddef>

namespace fresco
{

/// Calls work(i) for each i of [0, count) as parallel_for does, on progress.threads() threads. Looks for cancelation before each
/// piece of `grain` items.
template <std::integral Index, class Work>
void parallel_items(Index count, std::size_t grain, const Progress& progress, const Work& work)
{
    parallel_for(static_cast<std::size_t>(count), grain, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t i = begin; i < end; ++i)
                         work(static_cast<Index>(i));
                 });
}

}  // namespace fresco
