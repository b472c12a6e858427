#include "catch.h"

#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/optimizer_rule.h>

#include <ATen/ops/arange.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <ATen/ops/zeros.h>

using namespace fresco;

namespace
{

std::unique_ptr<OptimizerRule> made(const Value& options)
{
    auto rule = testing::make_from_plugin<OptimizerRule>(FRESCO_PLUGIN_FILE, "optimizer.lbfgs");
    testing::TestFactory factory;
    rule->configure(options, factory);
    return rule;
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

TEST_CASE("a rule goes on from its state with the same bytes")
{
    for (const char* search : {"strong_wolfe", "backtracking"})
    {
        const Value options = Value::Map{{"history_count", 3}, {"line_search", search}};
        auto whole = parameters();
        const auto rule = made(options);
        rule->attach(whole);
        for (int n = 0; n < 12; ++n)
            rule->step(whole, evaluation(whole, n), 0.05, 0.5);

        auto parts = parameters();
        TensorMap kept;
        {
            const auto first = made(options);
            first->attach(parts);
            for (int n = 0; n < 5; ++n)
                first->step(parts, evaluation(parts, n), 0.05, 0.5);
            for (const auto& [name, tensor] : first->state())
                kept.emplace(name, tensor.clone());
        }
        REQUIRE(kept.size() == 6);
        const auto second = made(options);
        second->attach(parts);
        second->restore(kept);
        for (int n = 5; n < 12; ++n)
            second->step(parts, evaluation(parts, n), 0.05, 0.5);
        CHECK(at::equal(whole[0].values, parts[0].values));
        CHECK(at::equal(whole[1].values, parts[1].values));
    }
}

TEST_CASE("the first step goes by the rate, returns the first loss and keeps to its evaluations")
{
    auto p = parameters();
    const auto rule = made(Value::Map{{"max_evaluations", 3}});
    rule->attach(p);
    const double before = evaluation(p, 0)().loss;
    int calls = 0;
    CHECK(rule->step(p, evaluation(p, 0, &calls), 0.01, 0) == before);
    CHECK(calls >= 2);
    CHECK(calls <= 3);
    // The steepest value is the third of the second parameter: 2 · 6 · 0.6.
    CHECK(p[1].values[0][2].item<float>() >= Approx(-0.49));
    CHECK(p[1].values[0][2].item<float>() <= Approx(-0.4));
    CHECK(p[1].values[1][2].item<float>() == -0.5F);
    CHECK(p[0].values[5][0].item<float>() == 0.5F);
    CHECK(evaluation(p, 0)().loss < before);
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

TEST_CASE("too large a texture and a state of another one are refused")
{
    auto p = parameters();
    const auto rule = made(Value::Map{{"history_count", 2}});
    rule->attach(p);
    rule->step(p, evaluation(p, 0), 0.05, 0);
    auto state = rule->state();
    REQUIRE(state.size() == 2);
    CHECK_NOTHROW(rule->restore(state));
    state.at("change.0") = at::zeros({5});
    CHECK_THROWS_WITH(rule->restore(state), Catch::Contains("change.0"));
    CHECK_THROWS_AS(rule->restore({{"change.0", at::zeros({24})}, {"first", at::zeros({24})}}), Error);

    const std::vector<TextureParameter> large{{"a", at::zeros({20'000, 3}), 0.0}};
    CHECK_NOTHROW(made(Value::Map{{"max_memory_mb", 7}})->attach(large));
    CHECK_THROWS_WITH(made(Value::Map{{"max_memory_mb", 6}})->attach(large), Catch::Contains("7 MB"));
}
