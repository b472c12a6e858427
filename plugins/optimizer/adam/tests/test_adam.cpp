#include "adam.h"
#include "catch.h"

#include <far_device.h>
#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/optimizer_rule.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace fresco;
using namespace fresco::adam;

TEST_CASE("Adam on another device steps as on the processor")
{
    constexpr std::int64_t texels = 40;
    const Constants constants{0.9, 0.99, 1e-8};
    for (const bool visible : {true, false})
    {
        CAPTURE(visible);
        const auto values = at::sin(at::arange(3 * texels, at::kFloat)).view({texels, 3});
        const auto near = values.clone();
        const auto first = at::zeros_like(near);
        const auto second = at::zeros_like(near);
        const auto steps = at::zeros({texels}, at::kInt);
        const Block block{near.data_ptr<float>(), first.data_ptr<float>(), second.data_ptr<float>(),
                          steps.data_ptr<std::int32_t>(), texels};
        const auto device = fresco::testing::far_device();
        TensorBlock there{values.to(device), first.to(device), second.to(device), steps.to(device)};
        for (std::int64_t step = 1; step <= 6; ++step)
        {
            const auto touched = at::arange(step % 3, texels, step, at::kLong);
            const auto gradient = at::cos(at::arange(3 * touched.numel(), at::kFloat)).view({-1, 3}) * step;
            const Gradient sparse{{touched.data_ptr<std::int64_t>(), static_cast<std::size_t>(touched.numel())},
                                  gradient.data_ptr<float>()};
            const auto far_touched = touched.to(device);
            const auto far_gradient = gradient.to(device);
            fresco::testing::forget_far_traffic();
            if (visible)
            {
                step_visible(block, sparse, 0.1, 0.02, constants, 2);
                step_visible(there, far_touched, far_gradient, 0.1, 0.02, constants);
            }
            else
            {
                step_dense(block, sparse, step, 0.1, 0.02, constants, 2);
                step_dense(there, far_touched, far_gradient, step, 0.1, 0.02, constants);
            }
            CHECK(fresco::testing::far_traffic().wait_count() == 0);
        }
        CHECK(at::allclose(there.values.cpu(), near, 1e-5, 1e-6));
        CHECK(at::allclose(there.second.cpu(), second, 1e-5, 1e-6));
        CHECK(at::allclose(there.first.cpu(), first, 1e-5, 1e-6));
        if (visible)
            CHECK(there.steps.cpu().equal(steps));
        CHECK((near - values).abs().max().item<float>() > 0.1);
    }
}

namespace
{

std::unique_ptr<OptimizerRule> made(const Value& options)
{
    auto rule = testing::make_from_plugin<OptimizerRule>(FRESCO_PLUGIN_FILE, "optimizer.adam");
    testing::TestFactory factory;
    rule->configure(options, factory);
    return rule;
}

std::vector<TextureParameter> parameters()
{
    return {{"a", at::full({6, 3}, 0.5F), 2.0}, {"b", at::full({2, 3}, -0.5F), 0.0}};
}

/// Step `n` sees texels n mod 6 and n mod 2.
Evaluate evaluation(int n)
{
    return [n]
    {
        Evaluation e;
        e.loss = n;
        e.gradients.push_back({at::full({1}, n % 6, at::kLong), at::full({1, 3}, 0.1F * static_cast<float>(n % 5 - 2))});
        e.gradients.push_back({at::full({1}, n % 2, at::kLong), at::full({1, 3}, 0.2F)});
        return e;
    };
}

/// Algorithm 1 for one number, beta1 0.8, beta2 0.95, epsilon 1e-3.
struct TextbookAdam
{
    double value = 0;
    double m = 0;
    double v = 0;
    int t = 0;
    void step(double g, double rate)
    {
        ++t;
        m = 0.8 * m + 0.2 * g;
        v = 0.95 * v + 0.05 * g * g;
        value -= rate * (m / (1 - std::pow(0.8, t))) / (std::sqrt(v / (1 - std::pow(0.95, t))) + 1e-3);
    }
};

}  // namespace

TEST_CASE("leaving untouched texels out changes no byte, from zeros, from values, and after a checkpoint")
{
    constexpr std::int64_t texels = 5000;
    const auto see = [](std::int64_t from)
    {
        return [from]
        {
            Evaluation e;
            e.gradients.push_back(
                {at::arange(from, from + 40, at::kLong), at::full({40, 3}, 0.1F * static_cast<float>(from % 7 - 3))});
            return e;
        };
    };
    for (const bool zeros : {true, false})
    {
        const auto run = [&](const char* untouched, bool interrupted)
        {
            std::vector<TextureParameter> p{{"a", at::zeros({texels, 3}), 2.0}};
            const Value options = Value::Map{{"untouched", untouched}};
            auto rule = made(options);
            rule->attach(p);
            // As a run does it: the texture gets its first values when the rule is there.
            if (!zeros)
                p[0].values.slice(0, 1000, 1300).fill_(0.5F);
            for (int n = 0; n < 12; ++n)
            {
                if (interrupted && n == 5)
                {
                    TensorMap kept;
                    for (const auto& [name, tensor] : rule->state())
                        kept.emplace(name, tensor.clone());
                    rule = made(options);
                    rule->attach(p);
                    rule->restore(kept);
                }
                rule->step(p, see(n < 8 ? 300 * n : 4001), 0.01, 0.5);
            }
            return p[0].values;
        };
        const auto all = run("step", false);
        CHECK(at::equal(run("skip", false), all));
        CHECK(at::equal(run("skip", true), all));
        CHECK(all[4010][0].item<float>() != 0);
    }
    CHECK_THROWS_AS(made(Value::Map{{"mode", "visible"}, {"untouched", "step"}})->attach(parameters()), Error);
}

TEST_CASE("both modes follow the textbook in double precision, the regularizer's gradient included")
{
    const double rate = 0.02;
    const double lambda = 0.7;
    for (const bool visible : {false, true})
    {
        auto p = parameters();
        const auto rule =
            made(Value::Map{{"mode", visible ? "visible" : "dense"}, {"beta1", 0.8}, {"beta2", 0.95}, {"epsilon", 1e-3}});
        rule->attach(p);
        // One number of each texel stands for all three.
        std::vector<TextbookAdam> twins(8);
        for (std::size_t i = 0; i < 8; ++i)
            twins[i].value = i < 6 ? 0.5 : -0.5;
        for (int n = 0; n < 30; ++n)
        {
            rule->step(p, evaluation(n), rate, lambda);
            for (std::size_t i = 0; i < 8; ++i)
            {
                const bool seen = i < 6 ? static_cast<int>(i) == n % 6 : static_cast<int>(i) - 6 == n % 2;
                if (visible && !seen)
                    continue;
                const double given = i < 6 ? 0.1 * (n % 5 - 2) : 0.2;
                // d/dv of λ k Σ v² / 18, k = 2; the second parameter has none.
                const double pull = i < 6 ? lambda * 2 * 2 * twins[i].value / 18 : 0;
                twins[i].step((seen ? given : 0) + pull, rate);
            }
        }
        for (std::size_t i = 0; i < 8; ++i)
        {
            const auto& values = p[i < 6 ? 0 : 1].values;
            for (std::int64_t c = 0; c < 3; ++c)
                CHECK(values[static_cast<std::int64_t>(i % 6)][c].item<double>() == Approx(twins[i].value).margin(3e-6));
        }
    }
}

TEST_CASE("a state of another texture or mode is refused")
{
    auto p = parameters();
    const auto rule = made(Value::Map{{"mode", "visible"}});
    rule->attach(p);
    auto state = rule->state();
    CHECK_NOTHROW(rule->restore(state));
    state.at("first.0") = at::zeros({5, 3});
    CHECK_THROWS_AS(rule->restore(state), Error);
    const auto dense = made(Value::Map{{"mode", "dense"}});
    dense->attach(p);
    CHECK_THROWS_AS(rule->restore(dense->state()), Error);
}
