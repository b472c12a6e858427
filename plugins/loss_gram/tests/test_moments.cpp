#include "moments.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include "catch.h"

#include <cmath>

namespace
{

/// Values in [0, 1) without a pattern that a wrong index would hide.
torch::Tensor some_features(std::int64_t channels, std::int64_t count)
{
    auto values = at::empty({channels, count}, at::kDouble);
    for (std::int64_t i = 0; i < values.numel(); ++i)
        values.data_ptr<double>()[i] = std::fmod(0.7548776662 * static_cast<double>(i * i % 7919 + i), 1.0);
    return values;
}

double gram_entry(const torch::Tensor& features, std::int64_t a, std::int64_t b)
{
    double sum = 0;
    for (std::int64_t i = 0; i < features.size(1); ++i)
        sum += features[a][i].item<double>() * features[b][i].item<double>();
    return sum / static_cast<double>(features.size(1));
}

}  // namespace

TEST_CASE("Moments of three features by hand")
{
    const auto features = at::tensor({1.0, 2.0, 3.0, 0.0, 1.0, 0.0}, at::kDouble).reshape({2, 3});
    const auto moments = gram::moments(features);
    CHECK(moments.mean[0].item<double>() == Approx(2));
    CHECK(moments.mean[1].item<double>() == Approx(1.0 / 3));
    CHECK(moments.second[0][0].item<double>() == Approx(14.0 / 3));
    CHECK(moments.second[0][1].item<double>() == Approx(2.0 / 3));
    CHECK(moments.second[1][0].item<double>() == Approx(2.0 / 3));
    CHECK(gram::covariance(moments)[0][0].item<double>() == Approx(14.0 / 3 - 4));
    CHECK(gram::covariance(moments)[0][1].item<double>() == Approx(0).margin(1e-12));
}

TEST_CASE("The blocked float32 Gram matrix is near the plain sum in double")
{
    const auto features = some_features(5, 9000);  // more than one block
    const auto moments = gram::moments(features.to(at::kFloat));
    for (std::int64_t a = 0; a < 5; ++a)
        for (std::int64_t b = 0; b < 5; ++b)
            CHECK(moments.second[a][b].item<double>() == Approx(gram_entry(features, a, b)).epsilon(1e-5));
}

TEST_CASE("Gradients of the moments agree with finite differences")
{
    const auto features = some_features(3, 7);
    const auto factor = some_features(3, 3);
    const auto value = [&](const torch::Tensor& f)
    {
        const auto m = gram::moments(f);
        return gram::relative_square_difference(gram::covariance(m), factor) +
               gram::mean_square_difference(m.second, factor) * 3 + gram::relative_square_difference(m.mean, factor[0]);
    };
    auto variable = features.clone().requires_grad_();
    value(variable).backward();
    const double step = 1e-6;
    for (std::int64_t i = 0; i < features.numel(); ++i)
    {
        auto up = features.clone();
        auto down = features.clone();
        up.data_ptr<double>()[i] += step;
        down.data_ptr<double>()[i] -= step;
        const double slope = (value(up).item<double>() - value(down).item<double>()) / (2 * step);
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-5).margin(1e-8));
    }
}

TEST_CASE("Moments and their gradient are the same bytes for any thread count")
{
    const int before = at::get_num_threads();
    const auto features = some_features(67, 20'000).to(at::kFloat);
    const auto run = [&](int threads)
    {
        at::set_num_threads(threads);
        auto variable = features.clone().requires_grad_();
        const auto m = gram::moments(variable);
        const auto value = gram::relative_square_difference(gram::covariance(m), at::ones({67, 67}));
        value.backward();
        return std::pair{m.second.detach(), variable.grad()};
    };
    const auto one = run(1);
    const auto two = run(2);
    at::set_num_threads(before);
    CHECK(at::equal(one.first, two.first));
    CHECK(at::equal(one.second, two.second));
}

TEST_CASE("Moments of all and of the fine features are those of each, and so are their gradients")
{
    const auto features = some_features(7, 500);
    const auto weights = some_features(7, 7);
    const auto value = [&](const gram::Moments& all, const gram::Moments& fine) {
        return (all.second * weights).sum() + 2 * all.mean.sum() + 3 * (fine.second * weights.t()).sum() - fine.mean.pow(2).sum();
    };
    for (const std::int64_t every : {1, 3})
        for (const bool turned : {false, true})
        {
            const auto given = turned ? features.t().contiguous().t() : features;
            const auto fine = at::arange(500).remainder(every).eq(0);
            const auto slow_input = given.detach().clone().requires_grad_();
            const auto fine_only = slow_input.index_select(1, fine.nonzero().flatten());
            const auto slow = value(gram::moments(slow_input), gram::moments(fine_only));
            slow.backward();
            const auto fast_input = given.detach().clone().requires_grad_();
            const fresco::FineColumns columns{fine.nonzero().flatten(), fine.logical_not().nonzero().flatten()};
            const auto both = gram::moments_of_both(fast_input, columns);
            REQUIRE(both.fine);
            const auto fast = value(both.all, *both.fine);
            fast.backward();
            CHECK(fast.item<double>() == Approx(slow.item<double>()).epsilon(1e-12));
            CHECK((fast_input.grad() - slow_input.grad()).abs().max().item<double>() <
                  1e-12 * slow_input.grad().abs().max().item<double>());
        }
    const auto none = gram::moments_of_both(features, {at::empty({0}, at::kLong), at::arange(500, at::kLong)});
    CHECK_FALSE(none.fine);
    CHECK(none.all.second.allclose(gram::moments(features).second));
}

TEST_CASE("Differences are relative to the target")
{
    const auto target = at::tensor({3.0, 4.0}, at::kDouble);
    CHECK(gram::relative_square_difference(at::tensor({3.0, 9.0}, at::kDouble), target).item<double>() == Approx(1));
    CHECK(gram::mean_square_difference(at::tensor({3.0, 9.0}, at::kDouble), target).item<double>() == Approx(12.5));
    CHECK(gram::relative_square_difference(target, at::zeros({2}, at::kDouble)).item<double>() == Approx(25));
}
