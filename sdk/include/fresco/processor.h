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

}  // namespace fresco
