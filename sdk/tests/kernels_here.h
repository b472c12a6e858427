#pragma once

#include <fresco/parallel.h>

#include <vector>

namespace fresco::testing
{

/// The kernels that this processor runs. A null pointer is one that the compiler could not make.
template <class Kernel>
std::vector<const Kernel*> kernels_here(const Kernel* base, const Kernel* avx2, const Kernel* avx512)
{
    std::vector<const Kernel*> kernels{base};
    if (avx2 != nullptr && runs_avx2())
        kernels.push_back(avx2);
    if (avx512 != nullptr && runs_avx512())
        kernels.push_back(avx512);
    return kernels;
}

}  // namespace fresco::testing
