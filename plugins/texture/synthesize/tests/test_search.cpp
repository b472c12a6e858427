#include "catch.h"
#include "search.h"

#include <fresco/parallel.h>
#include <fresco/random.h>

#include <cmath>
#include <functional>

using namespace fresco;
using namespace fresco::synthesize;

namespace
{

/// Kernels that this processor can run.
std::vector<const PatchKernel*> kernels()
{
    std::vector<const PatchKernel*> result{base_kernel()};
    if (avx2_kernel() != nullptr && runs_avx2())
        result.push_back(avx2_kernel());
    if (avx512_kernel() != nullptr && runs_avx512())
        result.push_back(avx512_kernel());
    return result;
}

std::vector<float> filled(std::size_t count, const std::function<double()>& value)
{
    std::vector<float> result(count);
    for (float& v : result)
        v = static_cast<float>(value());
    return result;
}

struct Problem
{
    FeatureSizes sizes;
    std::vector<float> keys;
    std::vector<float> queries;
    std::vector<float> weights;
    float lift = 0;

    double score(std::size_t query, std::size_t key) const
    {
        double distance = static_cast<double>(lift);
        double product = 0;
        for (std::size_t f = 0; f < sizes.all(); ++f)
        {
            const double q = static_cast<double>(queries[query * sizes.all() + f]);
            const double k = static_cast<double>(keys[key * sizes.all() + f]);
            (f < sizes.squared ? distance : product) += f < sizes.squared ? (q - k) * (q - k) : q * k;
        }
        return distance * static_cast<double>(weights[key]) + product;
    }

    /// The first of those with the least score.
    std::size_t best(std::size_t query) const
    {
        std::size_t result = 0;
        for (std::size_t k = 1; k < weights.size(); ++k)
            if (score(query, k) < score(query, result))
                result = k;
        return result;
    }
};

struct Size
{
    std::size_t keys, queries, squared, plain;
    int lift;
};
// Panels have 8 to 64 keys, groups 6 queries, blocks about 1 700 keys of 56 features.
const Size sizes[] = {{1, 1, 1, 0, 0},     {7, 5, 3, 0, 0},     {65, 13, 2, 1, 3},  {97, 7, 48, 8, 2},
                      {500, 61, 20, 8, 0}, {129, 12, 27, 0, 1}, {2000, 9, 48, 8, 8}};

}  // namespace

TEST_CASE("in whole numbers the best key is exact, and of equal ones the lowest")
{
    for (const PatchKernel* kernel : kernels())
        for (const Size& size : sizes)
        {
            CAPTURE(kernel->name, size.keys, size.queries, size.squared, size.plain);
            Random random(size.keys);
            // Few values, so that many keys are equal.
            const auto small = [&] { return static_cast<double>(random.below(3) - 1); };
            Problem problem;
            problem.sizes = {size.squared, size.plain};
            problem.keys = filled(size.keys * problem.sizes.all(), small);
            problem.queries = filled(size.queries * problem.sizes.all(), small);
            problem.weights = filled(size.keys, [&] { return std::exp2(static_cast<double>(random.below(2))); });
            problem.lift = static_cast<float>(size.lift);
            std::size_t wrong = 0;
            std::vector<Nearest> found(size.queries);
            NearestKeys(problem.keys, problem.sizes, problem.weights, problem.lift, *kernel)
                .find(problem.queries.data(), size.queries, found.data());
            for (std::size_t q = 0; q < found.size(); ++q)
            {
                const std::size_t best = problem.best(q);
                wrong += found[q].key != best || static_cast<double>(found[q].score) != problem.score(q, best);
            }
            CHECK(wrong == 0);
        }
}

TEST_CASE("squared distances of rows that are apart in memory are those of a plain loop")
{
    struct Block
    {
        std::size_t rows, length, stride;
    };
    for (const PatchKernel* kernel : kernels())
        for (const Block& block : {Block{1, 1, 1}, Block{5, 15, 40}, Block{11, 33, 33}, Block{9, 27, 300}, Block{31, 93, 94}})
        {
            CAPTURE(kernel->name, block.rows, block.length);
            Random random(block.rows);
            const auto any = [&] { return static_cast<double>(random.below(4096)) - 2048; };
            const auto whole = [&](std::size_t count)
            {
                const auto values = filled(count, any);
                return std::vector<std::int16_t>(values.begin(), values.end());
            };
            const auto a = whole(block.rows * block.length);
            const auto b = whole(block.rows * block.stride);
            double sum = 0;
            for (std::size_t y = 0; y < block.rows; ++y)
                for (std::size_t x = 0; x < block.length; ++x)
                    sum += std::pow(a[y * block.length + x] - b[y * block.stride + x], 2);
            CHECK(kernel->squared_distance(a.data(), b.data(), block.stride, block.rows, block.length) ==
                  static_cast<float>(sum));
        }
    CHECK(&patch_kernel() == kernels().back());
}
