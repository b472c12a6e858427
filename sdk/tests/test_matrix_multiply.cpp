#include "../src/matrix_kernel.h"
#include "catch.h"
#include "random_numbers.h"

#include <fresco/math.h>
#include <fresco/parallel.h>

#include <cmath>
#include <stdexcept>
#include <vector>

using fresco::testing::random_numbers;

namespace
{

double at(const fresco::MatrixView& m, std::size_t row, std::size_t column)
{
    return static_cast<double>(
        m.values[static_cast<std::ptrdiff_t>(row) * m.row_stride + static_cast<std::ptrdiff_t>(column) * m.column_stride]);
}

double largest_error(const fresco::MatrixView& a, const fresco::MatrixView& b, const std::vector<float>& c)
{
    double worst = 0;
    for (std::size_t row = 0; row < a.rows; ++row)
        for (std::size_t column = 0; column < b.columns; ++column)
        {
            double sum = 0;
            for (std::size_t k = 0; k < a.columns; ++k)
                sum += at(a, row, k) * at(b, k, column);
            worst = std::max(worst, std::abs(sum - static_cast<double>(c[row * b.columns + column])));
        }
    return worst;
}

}  // namespace

TEST_CASE("A product of matrices is the triple loop's, for every order in memory and any number of threads")
{
    struct Shape
    {
        std::size_t m, k, n;
    };
    for (const auto [m, k, n] :
         {Shape{1, 1, 1}, Shape{7, 300, 65}, Shape{97, 5, 257}, Shape{64, 8193, 64}, Shape{3, 20'000, 2}, Shape{200, 64, 300}})
        for (const bool a_turned : {false, true})
            for (const bool b_turned : {false, true})
            {
                CAPTURE(m, k, n, a_turned, b_turned);
                const auto a_values = random_numbers(m * k, 1);
                const auto b_values = random_numbers(k * n, 2);
                const auto wide = [](std::size_t i) { return static_cast<std::ptrdiff_t>(i); };
                const fresco::MatrixView a{a_values.data(), m, k, a_turned ? 1 : wide(k), a_turned ? wide(m) : 1};
                const fresco::MatrixView b{b_values.data(), k, n, b_turned ? 1 : wide(n), b_turned ? wide(k) : 1};
                std::vector<float> one(m * n, 7.0F);
                std::vector<float> three(m * n, 8.0F);
                fresco::multiply_matrices(a, b, one.data(), 1);
                fresco::multiply_matrices(a, b, three.data(), 3);
                CHECK(largest_error(a, b, one) < 1e-6 * std::sqrt(static_cast<double>(k)) + 1e-6);
                CHECK(one == three);
            }
}

TEST_CASE("A product over nothing is zero, and shapes that do not fit are refused")
{
    const float value = 3;
    std::vector<float> c(4, 1.0F);
    fresco::multiply_matrices({&value, 2, 0, 0, 1}, {&value, 0, 2, 2, 1}, c.data(), 1);
    CHECK(c == std::vector<float>(4));
    fresco::multiply_matrices({&value, 0, 5, 5, 1}, {&value, 5, 0, 0, 1}, nullptr, 2);
    CHECK_THROWS_AS(fresco::multiply_matrices({&value, 1, 2, 2, 1}, {&value, 1, 1, 1, 1}, c.data(), 1), std::invalid_argument);
}

TEST_CASE("Every processor's kernel adds the sum of its products")
{
    using namespace fresco::matrix;
    std::vector<const Kernel*> kernels{base_kernel(), &fastest_kernel()};
    if (avx2_kernel() != nullptr && fresco::runs_avx2())
        kernels.push_back(avx2_kernel());
    for (const auto* kernel : kernels)
    {
        constexpr std::size_t inner = 5;
        const auto a = random_numbers(inner * kernel->rows, 3);
        const auto b = random_numbers(inner * kernel->columns, 4);
        const auto step = [](std::size_t size) { return static_cast<std::ptrdiff_t>(size); };
        const fresco::MatrixView turned{a.data(), kernel->rows, inner, 1, step(kernel->rows)};
        const fresco::MatrixView wide{b.data(), inner, kernel->columns, step(kernel->columns), 1};
        std::vector<float> c(kernel->rows * kernel->columns);
        std::vector<const float*> rows;
        for (std::size_t row = 0; row < kernel->rows; ++row)
            rows.push_back(a.data() + row);
        for (const float before : {0.0F, 1.0F})
        {
            c.assign(c.size(), before);
            kernel->multiply(rows.data(), turned.column_stride, b.data(), wide.row_stride, inner, c.data(), kernel->columns);
            for (float& value : c)
                value -= before;
            CHECK(largest_error(turned, wide, c) < 1e-6);
        }
    }
}
