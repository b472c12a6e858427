#include "adam.h"
#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/torch/optimizer_rule.h>

#include <ATen/ATen.h>

#include <cmath>
#include <vector>

using namespace fresco;

namespace
{

std::unique_ptr<OptimizerRule> made(const Value& options)
{
    return testing::configured<OptimizerRule>("optimizer.adam", options);
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
        const auto run = [&](bool interrupted)
        {
            std::vector<TextureParameter> p{{"a", at::zeros({texels, 3}), 2.0}};
            const Value options = Value::Map{};
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
        const auto all = at::zeros({texels, 3});
        if (!zeros)
            all.slice(0, 1000, 1300).fill_(0.5F);
        const auto first = at::zeros({texels, 3}), second = at::zeros({texels, 3});
        for (int n = 0; n < 12; ++n)
        {
            const auto gradient = see(n < 8 ? 300 * n : 4001)().gradients[0];
            adam::step_dense(
                adam::Block{all.data_ptr<float>(), first.data_ptr<float>(), second.data_ptr<float>(), nullptr, texels},
                {{gradient.texels.data_ptr<std::int64_t>(), 40}, gradient.values.data_ptr<float>()}, n + 1, 0.01,
                2 * 0.5 * 2.0 / (3 * texels), {0.9, 0.999, 1e-8}, 1);
        }
        CHECK(at::equal(run(false), all));
        CHECK(at::equal(run(true), all));
        CHECK(all[4010][0].item<float>() != 0);
    }
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
