#include "lbfgs.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>

namespace fresco::lbfgs
{
namespace
{

constexpr std::size_t values_per_piece = 65536;

// Besides the pairs: values, where they were, direction, and three gradients.
constexpr std::size_t working_vectors = 6;

/// a += factor · b
void add(Vector& a, double factor, const Vector& b, int threads)
{
    const auto f = static_cast<float>(factor);
    parallel_for(a.size(), values_per_piece, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                         a[i] += f * b[i];
                 });
}

void scale(Vector& a, double factor, int threads)
{
    const auto f = static_cast<float>(factor);
    parallel_for(a.size(), values_per_piece, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                         a[i] *= f;
                 });
}

double largest(const Vector& a)
{
    float result = 0;
    for (const float value : a)
        result = std::max(result, std::abs(value));
    return static_cast<double>(result);
}

/// The function along start + step · direction. Keeps the gradient of the best point.
class VectorLine final : public Line
{
  public:
    VectorLine(const Vector& start, const Vector& line_direction, const Function& function, int threads)
        : start_(start), direction_(line_direction), function_(function), threads_(threads), x_(start.size()),
          gradient_(start.size())
    {
    }

    Sample at(double step) override
    {
        x_ = start_;
        add(x_, step, direction_, threads_);
        const double value = function_(x_, gradient_);
        return {step, value, dot(gradient_, direction_, threads_)};
    }

    void keep() override { kept_ = gradient_; }

    Vector& kept_gradient() { return kept_; }

  private:
    const Vector& start_;
    const Vector& direction_;
    const Function& function_;
    int threads_;
    Vector x_;
    Vector gradient_;
    Vector kept_;
};

}  // namespace

double dot(const Vector& a, const Vector& b, int threads)
{
    std::vector<double> sums((a.size() + values_per_piece - 1) / values_per_piece);
    parallel_for(a.size(), values_per_piece, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     double sum = 0;
                     for (std::size_t i = begin; i < end; ++i)
                         sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
                     sums[begin / values_per_piece] = sum;
                 });
    double total = 0;
    for (const double sum : sums)
        total += sum;
    return total;
}

Vector direction(const std::deque<Pair>& pairs, const Vector& gradient, int threads)
{
    Vector result = gradient;
    std::vector<double> shares(pairs.size());
    std::vector<double> products(pairs.size());
    for (std::size_t i = pairs.size(); i-- > 0;)
    {
        products[i] = dot(pairs[i].change, pairs[i].difference, threads);
        shares[i] = dot(pairs[i].change, result, threads) / products[i];
        add(result, -shares[i], pairs[i].difference, threads);
    }
    if (!pairs.empty())
        scale(result, products.back() / dot(pairs.back().difference, pairs.back().difference, threads), threads);
    for (std::size_t i = 0; i < pairs.size(); ++i)
        add(result, shares[i] - dot(pairs[i].difference, result, threads) / products[i], pairs[i].change, threads);
    scale(result, -1, threads);
    return result;
}

double step(Vector& x, std::deque<Pair>& pairs, const Function& function, const StepOptions& options, int threads)
{
    Vector gradient(x.size());
    const double value = function(x, gradient);
    const double square = dot(gradient, gradient, threads);
    if (!std::isfinite(value) || !std::isfinite(square) || !(square > 0))
        return value;

    Vector along = direction(pairs, gradient, threads);
    double slope = dot(gradient, along, threads);
    if (!(slope < 0) || !std::isfinite(slope))
    {
        pairs.clear();
        along = direction(pairs, gradient, threads);
        slope = -square;
    }
    const double fastest = largest(along);
    auto search = options.search;
    search.longest = options.largest_change / fastest;
    search.max_evaluations -= 1;
    const double first = pairs.empty() ? options.first_change / fastest : 1.0;

    VectorLine line(x, along, function, threads);
    const auto found = line_search({0, value, slope}, first, search, line);
    if (!(found.step > 0))
    {
        pairs.clear();
        return value;
    }
    Pair pair{x, std::move(line.kept_gradient())};
    add(x, found.step, along, threads);
    // What the rounded values really changed by.
    scale(pair.change, -1, threads);
    add(pair.change, 1, x, threads);
    add(pair.difference, -1, gradient, threads);
    const double curvature = dot(pair.change, pair.difference, threads);
    const double lengths = std::sqrt(dot(pair.change, pair.change, threads) * dot(pair.difference, pair.difference, threads));
    // Negative or lost in rounding: such a pair would make H indefinite.
    if (curvature > 1e-6 * lengths && lengths > 0)
        pairs.push_back(std::move(pair));
    while (pairs.size() > options.history_count)
        pairs.pop_front();
    return value;
}

double memory_bytes(std::size_t values, std::size_t pairs_count)
{
    return static_cast<double>(sizeof(float)) * static_cast<double>(values) *
           static_cast<double>(2 * (pairs_count + 1) + working_vectors);
}

}  // namespace fresco::lbfgs
