#include "adam.h"

#include <fresco/random.h>

#include "catch.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <cmath>
#include <far_device.h>
#include <vector>

using namespace fresco::adam;

namespace
{

constexpr Constants usual{.beta1 = 0.9, .beta2 = 0.999, .epsilon = 1e-8};

struct Memory
{
    explicit Memory(std::size_t n) : texels(n), values(3 * n, 0.25F), first(3 * n), second(3 * n), steps(n) {}
    std::size_t texels;
    std::vector<float> values, first, second;
    std::vector<std::int32_t> steps;
    Block block() { return {values.data(), first.data(), second.data(), steps.data(), texels}; }
    bool operator==(const Memory&) const = default;
};

/// Algorithm 1 of the paper for one number, in double precision.
struct Twin
{
    double value = 0.25;
    double m = 0;
    double v = 0;
    int t = 0;
    void step(double g, double rate, const Constants& c)
    {
        ++t;
        m = c.beta1 * m + (1 - c.beta1) * g;
        v = c.beta2 * v + (1 - c.beta2) * g * g;
        value -= rate * (m / (1 - std::pow(c.beta1, t))) / (std::sqrt(v / (1 - std::pow(c.beta2, t))) + c.epsilon);
    }
};

struct Step
{
    std::vector<std::int64_t> texels;
    std::vector<float> values;
    Gradient gradient() const { return {texels, values.data()}; }
};

std::vector<Step> random_steps(std::size_t texels, int count, std::uint64_t seed)
{
    fresco::Random random(seed);
    std::vector<Step> steps(static_cast<std::size_t>(count));
    for (auto& step : steps)
        for (std::size_t texel = 0; texel < texels; ++texel)
            if (random.uniform() < 0.5)
            {
                step.texels.push_back(static_cast<std::int64_t>(texel));
                for (int c = 0; c < 3; ++c)
                    step.values.push_back(static_cast<float>(random.uniform() - 0.5));
            }
    return steps;
}

}  // namespace

TEST_CASE("the first step goes by the rate, against the gradient's sign")
{
    Memory memory(2);
    const Step step{{1}, {0.5F, -2.0F, 0.0F}};
    step_visible(memory.block(), step.gradient(), 0.1, 0, usual, 1);
    CHECK(memory.values[3] == Approx(0.15F));
    CHECK(memory.values[4] == Approx(0.35F));
    CHECK(memory.values[5] == 0.25F);
    CHECK(memory.values[0] == 0.25F);
    CHECK(memory.steps == std::vector<std::int32_t>{0, 1});
}

TEST_CASE("dense steps follow the textbook on every texel")
{
    const Constants constants{0.8, 0.95, 1e-6};
    const double pull = 0.3;
    Memory memory(9);
    std::vector<Twin> twins(27);
    std::int64_t t = 0;
    for (const auto& step : random_steps(9, 40, 1))
    {
        step_dense(memory.block(), step.gradient(), ++t, 0.02, pull, constants, 1);
        std::vector<double> dense(27);
        for (std::size_t i = 0; i < step.texels.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c)
                dense[3 * static_cast<std::size_t>(step.texels[i]) + c] = static_cast<double>(step.values[3 * i + c]);
        for (std::size_t i = 0; i < 27; ++i)
            twins[i].step(dense[i] + pull * twins[i].value, 0.02, constants);
    }
    for (std::size_t i = 0; i < 27; ++i)
        CHECK(static_cast<double>(memory.values[i]) == Approx(twins[i].value).margin(2e-6));
}

TEST_CASE("visible steps follow the textbook on each texel's own steps")
{
    const Constants constants{0.8, 0.95, 1e-6};
    const double pull = 0.3;
    Memory memory(9);
    std::vector<Twin> twins(27);
    for (const auto& step : random_steps(9, 40, 2))
    {
        step_visible(memory.block(), step.gradient(), 0.02, pull, constants, 1);
        for (std::size_t i = 0; i < step.texels.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c)
            {
                auto& twin = twins[3 * static_cast<std::size_t>(step.texels[i]) + c];
                twin.step(static_cast<double>(step.values[3 * i + c]) + pull * twin.value, 0.02, constants);
            }
    }
    for (std::size_t i = 0; i < 27; ++i)
    {
        CHECK(static_cast<double>(memory.values[i]) == Approx(twins[i].value).margin(2e-6));
        CHECK(memory.steps[i / 3] == twins[i].t);
    }
}

TEST_CASE("runs of texels that nothing has moved are left out, with the same bytes")
{
    const std::size_t texels = 40 * texels_per_run + 17;
    for (const double pull : {0.0, 0.3})
    {
        Memory all(texels);
        std::fill(all.values.begin(), all.values.end(), 0.0F);
        // The regularizer moves what does not begin with zero; a moment moves on.
        all.values[3 * 5 * texels_per_run] = 0.5F;
        all.first[3 * 9 * texels_per_run + 2] = 0.1F;
        all.second[3 * 12 * texels_per_run + 1] = 0.1F;
        Memory some = all;
        std::vector<std::uint8_t> moved(run_count(texels), 7);
        auto block = some.block();
        block.moved = moved.data();
        mark_moved(block, 2);
        CHECK(std::count(moved.begin(), moved.end(), std::uint8_t{1}) == 3);
        CHECK(std::count(moved.begin(), moved.end(), std::uint8_t{0}) == std::ssize(moved) - 3);
        // The second step's runs are others than the first one's; the last run is a short one.
        for (std::int64_t t = 1; t <= 12; ++t)
        {
            Step step;
            const auto run = static_cast<std::int64_t>(texels_per_run);
            for (const std::int64_t texel : {t % 2 * run + 3, 20 * run - 1, 20 * run, static_cast<std::int64_t>(texels) - 1})
                for (int c = -1; c < 3; ++c)
                    if (c < 0)
                        step.texels.push_back(texel);
                    else
                        step.values.push_back(static_cast<float>(t + c) - 4.5F);
            step_dense(all.block(), step.gradient(), t, 0.02, pull, usual, 1);
            step_dense(block, step.gradient(), t, 0.02, pull, usual, 3);
        }
        CHECK(some == all);
        CHECK(std::count(moved.begin(), moved.end(), std::uint8_t{1}) == 8);
        CHECK((moved[0] == 1 && moved[1] == 1 && moved[19] == 1 && moved[20] == 1 && moved.back() == 1));
    }
}

TEST_CASE("steps give the same bytes for any number of threads")
{
    const std::size_t texels = 50000;
    const auto steps = random_steps(texels, 3, 3);
    for (const bool dense : {false, true})
    {
        std::vector<Memory> results;
        for (const int threads : {1, 3})
        {
            Memory memory(texels);
            std::int64_t t = 0;
            for (const auto& step : steps)
            {
                if (dense)
                    step_dense(memory.block(), step.gradient(), ++t, 0.02, 0.1, usual, threads);
                else
                    step_visible(memory.block(), step.gradient(), 0.02, 0.1, usual, threads);
            }
            results.push_back(std::move(memory));
        }
        CHECK(results[0] == results[1]);
    }
}

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
