#include "lbfgs.h"
#include "random_numbers.h"

#include "catch.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace fresco;
using namespace fresco::lbfgs;
using fresco::testing::random_numbers;

namespace
{

/// A function of one number, counting its calls.
class Curve final : public Line
{
  public:
    Curve(std::function<double(double)> value, std::function<double(double)> slope)
        : value_(std::move(value)), slope_(std::move(slope))
    {
    }
    Sample at(double step) override
    {
        ++calls;
        last = step;
        return {step, value_(step), slope_(step)};
    }
    void keep() override { kept = last; }
    Sample start() const { return {0, value_(0), slope_(0)}; }

    int calls = 0;
    double last = 0;
    double kept = 0;

  private:
    std::function<double(double)> value_;
    std::function<double(double)> slope_;
};

/// Sum of 100 (x[2i+1] - x[2i]²)² + (1 - x[2i])².
double rosenbrock(const Vector& x, Vector& gradient)
{
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); i += 2)
    {
        const auto a = static_cast<double>(x[i]);
        const double rise = static_cast<double>(x[i + 1]) - a * a;
        sum += 100 * rise * rise + (1 - a) * (1 - a);
        gradient[i] = static_cast<float>(-400 * a * rise - 2 * (1 - a));
        gradient[i + 1] = static_cast<float>(200 * rise);
    }
    return sum;
}

/// Sum of (i + 1)² (x[i] - 1)² / 2.
double bowl(const Vector& x, Vector& gradient)
{
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
    {
        const double stiffness = std::pow(static_cast<double>(i) + 1, 2);
        const double away = static_cast<double>(x[i]) - 1;
        sum += stiffness * away * away / 2;
        gradient[i] = static_cast<float>(stiffness * away);
    }
    return sum;
}

}  // namespace

TEST_CASE("the direction is that of the dense BFGS matrix in double precision")
{
    const std::size_t n = 6;
    std::deque<Pair> pairs;
    for (std::uint64_t i = 0; i < 4; ++i)
    {
        Pair pair{random_numbers(n, 2 * i), random_numbers(n, 2 * i + 1)};
        if (dot(pair.change, pair.difference, 1) < 0)
            for (float& value : pair.difference)
                value = -value;
        pairs.push_back(std::move(pair));
    }
    const auto gradient = random_numbers(n, 99);
    // H <- (I - s yᵀ / ys) H (I - y sᵀ / ys) + s sᵀ / ys, from γ I.
    const auto& newest = pairs.back();
    const double gamma = dot(newest.change, newest.difference, 1) / dot(newest.difference, newest.difference, 1);
    std::vector<std::vector<double>> h(n, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i)
        h[i][i] = gamma;
    for (const auto& [s, y] : pairs)
    {
        const double ys = dot(s, y, 1);
        auto left = h;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j)
                for (std::size_t k = 0; k < n; ++k)
                    left[i][j] -= static_cast<double>(s[i]) * static_cast<double>(y[k]) / ys * h[k][j];
        h = left;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j)
            {
                for (std::size_t k = 0; k < n; ++k)
                    h[i][j] -= left[i][k] * static_cast<double>(y[k]) * static_cast<double>(s[j]) / ys;
                h[i][j] += static_cast<double>(s[i]) * static_cast<double>(s[j]) / ys;
            }
    }
    const auto found = direction(pairs, gradient, 2);
    for (std::size_t i = 0; i < n; ++i)
    {
        double expected = 0;
        for (std::size_t j = 0; j < n; ++j)
            expected -= h[i][j] * static_cast<double>(gradient[j]);
        CHECK(static_cast<double>(found[i]) == Approx(expected).epsilon(1e-4).margin(1e-5));
    }
    const auto steepest = direction({}, gradient, 1);
    for (std::size_t i = 0; i < n; ++i)
        CHECK(steepest[i] == -gradient[i]);
}

TEST_CASE("the line search ends where both conditions hold")
{
    const auto wave = [](double c)
    {
        return Curve([c](double t) { return -std::sin(c * t) + 0.1 * t * t; },
                     [c](double t) { return -c * std::cos(c * t) + 0.2 * t; });
    };
    SearchOptions options{.strong_wolfe = true, .max_evaluations = 20};
    options.curvature = 0.1;
    for (const double c : {0.01, 0.3, 1.0, 7.0})
        for (const double first : {1e-3, 0.4, 30.0})
        {
            auto curve = wave(c);
            const auto start = curve.start();
            const auto found = line_search(start, first, options, curve);
            CHECK(found.step > 0);
            CHECK(found.value <= start.value + options.sufficient * found.step * start.slope);
            CHECK(std::abs(found.slope) <= -options.curvature * start.slope);
            CHECK(curve.kept == found.step);
        }
}

TEST_CASE("the line search keeps to its limits")
{
    Curve steep([](double t) { return -t; }, [](double) { return -1.0; });
    SearchOptions options{.strong_wolfe = true, .max_evaluations = 8};
    options.longest = 3;
    CHECK(line_search(steep.start(), 1, options, steep).step == 3);
    CHECK(steep.kept == 3);
    options.longest = 1e30;
    options.max_evaluations = 4;
    steep.calls = 0;
    CHECK(line_search(steep.start(), 1, options, steep).step > 3);
    CHECK(steep.calls == 4);

    Curve rising([](double t) { return t < 1e-9 ? -t : 5.0; }, [](double) { return -1.0; });
    for (const bool wolfe : {true, false})
    {
        options.strong_wolfe = wolfe;
        rising.calls = 0;
        CHECK(line_search(rising.start(), 1, options, rising).step == 0);
        CHECK(rising.calls == 4);
        CHECK(rising.kept == 0);
    }
}

TEST_CASE("points that are not finite are too far")
{
    const auto nan = std::numeric_limits<double>::quiet_NaN();
    for (const bool wolfe : {true, false})
    {
        Curve walled([nan](double t) { return t < 1 ? (t - 0.4) * (t - 0.4) : nan; }, [](double t) { return 2 * (t - 0.4); });
        const SearchOptions options{.strong_wolfe = wolfe, .max_evaluations = 8};
        const auto found = line_search(walled.start(), 4, options, walled);
        CHECK(found.step > 0);
        CHECK(found.step < 0.8);
    }
}

TEST_CASE("backtracking halves the step until the value has fallen enough")
{
    Curve parabola([](double t) { return (t - 1) * (t - 1); }, [](double t) { return 2 * (t - 1); });
    const SearchOptions options{.strong_wolfe = false, .max_evaluations = 8};
    CHECK(line_search(parabola.start(), 5, options, parabola).step == 1.25);
    CHECK(parabola.calls == 3);
}

TEST_CASE("a quadratic bowl and Rosenbrock's valley are descended to their ends")
{
    for (const bool wolfe : {true, false})
    {
        const StepOptions options{.history_count = 10,
                                  .search = {.strong_wolfe = wolfe, .max_evaluations = 20},
                                  .first_change = 0.1,
                                  .largest_change = 10};
        std::deque<Pair> pairs;
        Vector x(12, 0.0F);
        for (int i = 0; i < 60; ++i)
            step(x, pairs, bowl, options, 2);
        for (const float value : x)
            CHECK(value == Approx(1).margin(1e-3));
        CHECK(pairs.size() <= 10);

        pairs.clear();
        Vector valley(10);
        for (std::size_t i = 0; i < valley.size(); i += 2)
        {
            valley[i] = -1.2F;
            valley[i + 1] = 1.0F;
        }
        valley[0] = 0.3F;
        for (int i = 0; i < 150; ++i)
            step(valley, pairs, rosenbrock, options, 2);
        for (const float value : valley)
            CHECK(value == Approx(1).margin(5e-3));
    }
}

TEST_CASE("the first step and every later one keep to the largest change")
{
    const StepOptions options{.history_count = 10,
                              .search = {.strong_wolfe = true, .max_evaluations = 8},
                              .first_change = 0.01,
                              .largest_change = 0.05};
    std::deque<Pair> pairs;
    Vector x(12, 0.0F);
    for (int i = 0; i < 10; ++i)
    {
        const auto before = x;
        step(x, pairs, bowl, options, 1);
        float moved = 0;
        for (std::size_t k = 0; k < x.size(); ++k)
            moved = std::max(moved, std::abs(x[k] - before[k]));
        CHECK(moved > 0);
        CHECK(moved <= 0.05001F);
    }
}

TEST_CASE("a start that is not finite, or flat, changes nothing; a line without a lower point forgets the pairs")
{
    std::deque<Pair> pairs{{Vector{1, 0}, Vector{1, 0}}};
    Vector x{1, 2};
    const auto broken = [](const Vector&, Vector& gradient)
    {
        gradient.assign(2, 1.0F);
        return std::numeric_limits<double>::quiet_NaN();
    };
    CHECK(std::isnan(step(x, pairs, broken, {}, 1)));
    const auto flat = [](const Vector&, Vector& gradient)
    {
        gradient.assign(2, 0.0F);
        return 3.0;
    };
    CHECK(step(x, pairs, flat, {}, 1) == 3);
    CHECK(pairs.size() == 1);
    const auto wrong_gradient = [](const Vector& at, Vector& gradient)
    {
        gradient.assign(2, -1.0F);
        return static_cast<double>(at[0] + at[1]);
    };
    step(x, pairs, wrong_gradient, {}, 1);
    CHECK(x == Vector{1, 2});
    CHECK(pairs.empty());
}

TEST_CASE("sums and directions are the same for any number of threads")
{
    std::deque<Pair> pairs;
    const std::size_t n = 300'000;
    for (std::uint64_t i = 0; i < 3; ++i)
    {
        const auto change = random_numbers(n, i);
        auto difference = change;
        for (std::size_t k = 0; k < n; ++k)
            difference[k] = difference[k] * static_cast<float>(1 + k % 7) + 0.01F;
        pairs.push_back({change, difference});
    }
    const auto gradient = random_numbers(n, 9);
    CHECK(dot(gradient, pairs[0].change, 1) == dot(gradient, pairs[0].change, 3));
    CHECK((direction(pairs, gradient, 1) == direction(pairs, gradient, 3)));
    CHECK(memory_bytes(1000, 10) == 4.0 * 1000 * 28);
}
