#pragma once

#include <cstddef>
#include <span>

namespace fresco::numerics
{

/// Solves A x = b in place by Cholesky, for each column of `right`: N x `columns`, row-major. `matrix`: N x N, row-major,
/// symmetric and positive definite; only its lower triangle is read, and overwritten.
void solve_symmetric(std::span<double> matrix, std::span<double> right, std::size_t columns = 1);

}  // namespace fresco::numerics
