#include "catch.h"

#include <fresco/numerics/solve_symmetric.h>
#include <fresco/random.h>

#include <cmath>
#include <vector>

TEST_CASE("symmetric systems are solved")
{
    // A = B Bᵀ + 1 with random B; x is known.
    constexpr std::size_t n = 23, columns = 3;
    fresco::Random random(2);
    std::vector<double> b(n * n), a(n * n), x(n * columns), right(n * columns);
    for (auto* values : {&b, &x})
        for (double& value : *values)
            value = random.normal();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
        {
            for (std::size_t k = 0; k < n; ++k)
                a[i * n + j] += b[i * n + k] * b[j * n + k];
            a[i * n + j] += i == j;
            for (std::size_t c = 0; c < columns; ++c)
                right[i * columns + c] += a[i * n + j] * x[j * columns + c];
        }
    for (std::size_t i = 0; i < n; ++i)  // Only the lower triangle is read.
        for (std::size_t j = i + 1; j < n; ++j)
            a[i * n + j] = std::nan("");
    fresco::numerics::solve_symmetric(a, right, columns);
    for (std::size_t i = 0; i < right.size(); ++i)
        CHECK(right[i] == Approx(x[i]).margin(1e-8));
}
