#include "random_tensor.h"
#include "search.h"

#include <fresco/error.h>
#include <fresco/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include "catch.h"

#include <cmath>
#include <limits>
#include <vector>

using fresco::testing::random_tensor;
namespace pm = patch_match;

namespace
{

double squares(const torch::Tensor& a, const torch::Tensor& b)
{
    return (a.to(at::kDouble) - b.to(at::kDouble)).pow(2).sum().item<double>();
}

/// All distances, one at a time, in double.
std::vector<std::vector<double>> divided_distances(const pm::SearchInput& input)
{
    const auto queries = static_cast<std::size_t>(input.patches.size(0));
    const auto count = static_cast<std::size_t>(input.style.size(0));
    std::vector<std::vector<double>> result(queries, std::vector<double>(count));
    for (std::size_t i = 0; i < queries; ++i)
        for (std::size_t j = 0; j < count; ++j)
        {
            const auto q = static_cast<std::int64_t>(i);
            const auto s = static_cast<std::int64_t>(j);
            result[i][j] =
                squares(input.patches[q], input.style[s]) + input.guide_weight * squares(input.guide[q], input.style[s]);
        }
    for (std::size_t j = 0; j < count; ++j)
    {
        double best = std::numeric_limits<double>::max();
        for (std::size_t i = 0; i < queries; ++i)
            best = std::min(best, result[i][j]);
        for (std::size_t i = 0; i < queries; ++i)
            result[i][j] /= input.tolerance + best;
    }
    return result;
}

}  // namespace

TEST_CASE("The search agrees with every distance computed one at a time")
{
    const pm::SearchInput input{.patches = random_tensor({40, 6}, 1) + 0.5,
                                .guide = random_tensor({40, 6}, 2) + 0.5,
                                .style = random_tensor({60, 6}, 3) + 0.5,
                                .guide_weight = 0.2,
                                .tolerance = 0.05};
    const auto expected = divided_distances(input);
    const auto found = pm::nearest_patches(input, fresco::Progress{});
    for (std::size_t i = 0; i < expected.size(); ++i)
    {
        const auto best = std::min_element(expected[i].begin(), expected[i].end());
        CHECK(found[static_cast<std::int64_t>(i)].item<int>() == best - expected[i].begin());
    }
}

TEST_CASE("Completeness asks for what plain distances leave out")
{
    // Patches at 0, 1, 2 on a line; style at 0.9, 1.1 and far away at 10.
    const auto patches = at::tensor({0.0F, 1.0F, 2.0F}).reshape({3, 1});
    const auto style = at::tensor({0.9F, 1.1F, 10.0F}).reshape({3, 1});
    pm::SearchInput input{.patches = patches, .guide = patches, .style = style, .guide_weight = 0, .tolerance = 1e6};
    CHECK(at::equal(pm::nearest_patches(input, fresco::Progress{}), at::tensor({0, 0, 1}, at::kInt)));
    input.tolerance = 1e-6;
    // Divided by (0.01, 0.01, 64): 2 is (121, 81, 1) from them.
    CHECK(at::equal(pm::nearest_patches(input, fresco::Progress{}), at::tensor({2, 0, 2}, at::kInt)));
}

TEST_CASE("The guide pulls an undecided patch")
{
    const pm::SearchInput input{.patches = at::tensor({0.0F}).reshape({1, 1}),
                                .guide = at::tensor({1.0F}).reshape({1, 1}),
                                .style = at::tensor({-0.99F, 1.0F}).reshape({2, 1}),
                                .guide_weight = 0.2,
                                .tolerance = 1e6};
    CHECK(pm::nearest_patches(input, fresco::Progress{})[0].item<int>() == 1);
}

TEST_CASE("Blocks and threads change no result, and a style patch finds itself")
{
    const auto style = random_tensor({5000, 8}, 1) + 0.5;  // more than one block of style patches
    const auto own = at::arange(0, 5000, 16, at::kLong);
    const pm::SearchInput input{.patches = style.index_select(0, own),  // more than one block of queries
                                .guide = style.index_select(0, own),
                                .style = style,
                                .guide_weight = 0.2,
                                .tolerance = 1e9};
    const auto one = pm::nearest_patches(input, fresco::testing::TestRun(1));
    const auto two = pm::nearest_patches(input, fresco::testing::TestRun(3));
    CHECK(at::equal(one, two));
    for (std::int64_t i = 0; i < own.numel(); ++i)
        CHECK(squares(style[one[i].item<std::int64_t>()], style[own[i].item<std::int64_t>()]) < 1e-4);
}

TEST_CASE("A search can be stopped")
{
    fresco::testing::TestRun run;
    run.cancel_after(1);
    const auto keys = random_tensor({10, 2}, 1) + 0.5;
    CHECK_THROWS_AS(pm::nearest_patches({.patches = keys, .guide = keys, .style = keys, .guide_weight = 0, .tolerance = 1}, run),
                    fresco::Canceled);
}
