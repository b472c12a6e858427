#pragma once

/// \file Which of the inner loops that fresco_add_processor_kinds compiles this processor runs.

namespace fresco
{

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
