#pragma once

#include "line_search.h"

#include <cstddef>
#include <deque>
#include <functional>
#include <span>
#include <vector>

/// \file L-BFGS (Liu and Nocedal, "On the limited memory BFGS method for large scale optimization", 1989) on dense float32
/// vectors. Sums are in double precision and in a fixed order: results do not depend on `threads`.

namespace fresco::lbfgs
{

using Vector = std::vector<float>;

/// The function at `x`; writes its derivatives to `gradient`, which has as many entries.
using Function = std::function<double(const Vector& x, Vector& gradient)>;

/// What a step changed, and how it changed the gradient of the step's function.
struct Pair
{
    Vector change;
    Vector difference;
};

double dot(const Vector& a, const Vector& b, int threads);

/// -H·gradient for the inverse Hessian H that `pairs`, oldest first, make of the diagonal (change·difference) /
/// (difference·difference) of the newest (Nocedal and Wright, algorithm 7.4); -gradient without any pairs. Every
/// change·difference is > 0.
Vector direction(const std::deque<Pair>& pairs, const Vector& gradient, int threads);

struct StepOptions
{
    std::size_t history_count;  ///< Pairs that are kept.
    SearchOptions search;       ///< `longest` is set from largest_change; the evaluation at the start is counted too.
    double first_change;        ///< Largest change of a value in the first trial where there are no pairs.
    double largest_change;      ///< Of a value in any trial.
};

/// One step from `x`: the function is evaluated there, a direction chosen, and the line searched. Returns the value at the start.
/// Adds to `pairs` and removes the oldest beyond history_count; only gradients of this very function make a pair, so the function
/// may be another one in every step. Where no point on the line is lower, x stays and the pairs are forgotten; where the value or
/// a derivative at the start is not finite, nothing changes.
double step(Vector& x, std::deque<Pair>& pairs, const Function& function, const StepOptions& options, int threads);

/// Bytes held at the peak of a step.
double memory_bytes(std::size_t values, std::size_t pairs_count);

}  // namespace fresco::lbfgs
