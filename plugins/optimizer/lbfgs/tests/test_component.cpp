#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/error.h>
#include <fresco/torch/optimizer_rule.h>

#include <ATen/Parallel.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <ATen/ops/zeros.h>

using namespace fresco;

namespace
{

std::unique_ptr<OptimizerRule> made(const Value& options)
{
    return testing::configured<OptimizerRule>("optimizer.lbfgs", options);
}

std::vector<TextureParameter> parameters()
{
    return {{"a", at::full({6, 3}, 0.5F), 2.0}, {"b", at::full({2, 3}, -0.5F), 0.0}};
}

/// Step `n` sees three texels of the first parameter and one of the second: Σ stiffness (value - goal)², on those.
Evaluate evaluation(const std::vector<TextureParameter>& parameters, std::int64_t n, int* calls = nullptr)
{
    return [&parameters, n, calls]
    {
        if (calls != nullptr)
            ++*calls;
        Evaluation result;
        for (std::size_t block = 0; block < parameters.size(); ++block)
        {
            const std::int64_t count = block == 0 ? 3 : 1;
            const auto texels = at::arange(count, at::kLong) + n % (block == 0 ? 4 : 2);
            const auto values = parameters[block].values.index_select(0, texels);
            const auto stiffness = at::arange(1, 4, at::kFloat) * static_cast<double>(block + 1);
            const auto away = values - 0.1 * static_cast<double>(block);
            result.loss += (stiffness * away * away).sum().item<double>();
            result.gradients.push_back({texels, 2 * stiffness * away});
        }
        return result;
    };
}

}  // namespace

TEST_CASE("a step lowers the view's loss, keeps to its largest change and leaves other texels; nothing is remembered")
{
    auto p = parameters();
    const auto rule = made(Value::Map{});
    rule->attach(p);
    const double before = evaluation(p, 0)().loss;
    int calls = 0;
    CHECK(rule->step(p, evaluation(p, 0, &calls), 0.002, 0) == before);
    CHECK(calls >= 2);
    CHECK(evaluation(p, 0)().loss < before);
    // All that is seen is farther than that from its goal.
    CHECK(p[1].values[0][2].item<float>() == Approx(-0.48));
    CHECK(p[0].values[1][0].item<float>() == Approx(0.48));
    CHECK(p[1].values[1][2].item<float>() == -0.5F);
    CHECK(p[0].values[5][0].item<float>() == 0.5F);
    CHECK(rule->state().empty());
}

TEST_CASE("a view's quadratic is minimized within a step, with the same bytes for any number of threads")
{
    const int threads = at::get_num_threads();
    std::vector<std::vector<TextureParameter>> results;
    for (const int count : {1, 3})
    {
        at::set_num_threads(count);
        // Large enough for libtorch to share out its sums.
        std::vector<TextureParameter> p{{"a", at::arange(300'000, at::kFloat).reshape({100'000, 3}) * 1e-5 + 0.7, 1.0},
                                        {"b", at::full({2, 3}, -0.5F), 0.0}};
        const auto rule = made(Value::Map{{"iterations_count", 20}});
        rule->attach(p);
        rule->step(p, evaluation(p, 0), 1, 0.01);
        CHECK(at::get_num_threads() == count);
        CHECK(evaluation(p, 0)().loss < 1e-4);
        results.push_back(p);
    }
    at::set_num_threads(threads);
    CHECK(at::equal(results[0][0].values, results[1][0].values));
    CHECK(at::equal(results[0][1].values, results[1][1].values));
}

TEST_CASE("the regularizer is part of what is minimized")
{
    // On one texel and channel: s (v - g)² + λ k v² / 18 with s = 2, g = 0 for block 0: only the regularizer acts on unseen
    // texels.
    auto p = parameters();
    const auto rule = made(Value::Map{});
    rule->attach(p);
    // Pulls the first value of the first parameter by a constant 0.2.
    const Evaluate linear = [&p]
    {
        Evaluation result;
        result.gradients.push_back({at::zeros({1}, at::kLong), at::zeros({1, 3})});
        result.gradients[0].values[0][0] = 0.2F;
        result.gradients.push_back({at::zeros({0}, at::kLong), at::zeros({0, 3})});
        result.loss = 0.2 * p[0].values[0][0].item<double>();
        return result;
    };
    for (int n = 0; n < 20; ++n)
        rule->step(p, linear, 0.1, 9.0);
    // λ k mean(v²) = 9 · 2 / 18 Σ v²: the minimum of 0.2 v + v² is at -0.1, of v² at 0; the other parameter has no regularizer.
    CHECK(p[0].values[0][0].item<float>() == Approx(-0.1).margin(1e-3));
    CHECK(p[0].values[5][2].item<float>() == Approx(0).margin(1e-3));
    CHECK(p[1].values[0][0].item<float>() == -0.5F);
}

TEST_CASE("too large a texture is refused")
{
    const auto attach = [](std::int64_t texels) {
        made(Value::Map{})->attach({{"a", at::empty({texels, 3}), 0.0}});
    };  // Memory that nobody touches takes none.
    CHECK_NOTHROW(attach(17'000'000));
    CHECK_THROWS_WITH(attach(18'000'000), Catch::Contains("4320 MB") && Catch::Contains("more than 4096"));
}
