#include <fresco/numerics/solve_symmetric.h>

#include <cmath>

namespace fresco::numerics
{

void solve_symmetric(std::span<double> matrix, std::span<double> right, std::size_t columns)
{
    const std::size_t n = right.size() / columns;
    const auto at = [&](std::size_t row, std::size_t column) -> double& { return matrix[row * n + column]; };
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j)
        {
            double sum = at(i, j);
            for (std::size_t k = 0; k < j; ++k)
                sum -= at(i, k) * at(j, k);
            at(i, j) = i == j ? std::sqrt(sum) : sum / at(j, j);
        }
    for (std::size_t c = 0; c < columns; ++c)
    {
        const auto x = [&](std::size_t row) -> double& { return right[row * columns + c]; };
        for (std::size_t i = 0; i < n; ++i)
        {
            for (std::size_t k = 0; k < i; ++k)
                x(i) -= at(i, k) * x(k);
            x(i) /= at(i, i);
        }
        for (std::size_t i = n; i-- > 0;)
        {
            for (std::size_t k = i + 1; k < n; ++k)
                x(i) -= at(k, i) * x(k);
            x(i) /= at(i, i);
        }
    }
}

}  // namespace fresco::numerics
