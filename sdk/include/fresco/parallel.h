#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <string_view>

/// \file How stages use the threads and the vectors of the processor, with the same bytes for any number of threads.

namespace fresco
{

/// Reports how far a long algorithm is, and tells it to stop. Callable from any thread.
class Progress
{
  public:
    virtual ~Progress();
    /// `done` of `total` units ("frames", "faces", "steps"); total 0 = unknown. Cheap: call it as often as you like.
    virtual void progress(double done, double total, std::string_view unit);
    /// Throws fresco::Canceled once the run must stop. Call it at least every second.
    virtual void check_canceled() const;
    /// Threads this work may use; results do not depend on it. In a run, the same from beginning to end. Never throws.
    virtual int threads() const;
};

/// Calls `work(begin, end)` for pieces of [0, count) of at most `grain` items on up to progress.threads() threads.
/// The pieces depend only on `count` and `grain`, never on the threads, so that per-piece results
/// summed in order are the same for any thread count. The first exception (by piece) is rethrown after all threads have ended.
/// Blocks until done.
void parallel_for(std::size_t count, std::size_t grain, const Progress& progress,
                  const std::function<void(std::size_t, std::size_t)>& work);
/// Calls `work` on up to `threads` threads.
void parallel_for(std::size_t count, std::size_t grain, int threads, const std::function<void(std::size_t, std::size_t)>& work);

/// Calls work(i) for each i of [0, count) as parallel_for does. Looks for cancelation before each piece of `grain` items.
template <std::integral Index, class Work>
void parallel_items(Index count, std::size_t grain, const Progress& progress, const Work& work)
{
    parallel_for(static_cast<std::size_t>(count), grain, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t i = begin; i < end; ++i)
                         work(static_cast<Index>(i));
                 });
}

/// Calls `work(i)` for each item as parallel_for does, one by one. Looks for cancelation before each and reports afterward how
/// many are done, in `unit` ("views").
void parallel_for_each(std::size_t count, std::string_view unit, Progress& progress,
                       const std::function<void(std::size_t)>& work);

/// AVX2 and FMA.
inline bool runs_avx2()
{
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
#else
    return false;
#endif
}

/// AVX-512 F, BW, VL and DQ: all that these loops are compiled with.
inline bool runs_avx512()
{
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
           __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512dq") != 0;
#else
    return false;
#endif
}

/// The fastest of three kernels that this processor runs. The first two may be null: not compiled for this architecture.
template <class Kernel>
const Kernel& fastest_of(const Kernel* avx512, const Kernel* avx2, const Kernel* base)
{
    if (avx512 != nullptr && runs_avx512())
        return *avx512;
    return avx2 != nullptr && runs_avx2() ? *avx2 : *base;
}

}  // namespace fresco
