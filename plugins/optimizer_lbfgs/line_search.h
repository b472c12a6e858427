#pragma once

/// \file How far to go along a line. Nocedal and Wright, "Numerical Optimization", 2nd edition, section 3.5.

namespace fresco::lbfgs
{

/// A point on the line: the function and its derivative along the line at `step`.
struct Sample
{
    double step = 0;
    double value = 0;
    double slope = 0;
};

/// The function along a line.
class Line
{
  public:
    virtual ~Line() = default;
    virtual Sample at(double step) = 0;
    /// The last point asked for is the best so far: the search returns no point that it did not keep, except the start.
    virtual void keep() = 0;
};

struct SearchOptions
{
    bool strong_wolfe;         ///< Both conditions; otherwise halve the step until the first holds.
    int max_evaluations;       ///< Calls of at().
    double sufficient = 1e-4;  ///< value <= start's + sufficient · step · start's slope
    double curvature = 0.9;    ///< |slope| <= curvature · |start's slope|
    double longest = 1e30;     ///< No step beyond this.
};

/// From `start` (step 0, slope < 0), with `first` > 0 as the first step. Returns a point that satisfies the conditions; where the
/// evaluations do not suffice, the lowest that satisfies the first; where there is none, `start`. Points that are not finite
/// count as too far.
Sample line_search(const Sample& start, double first, const SearchOptions& options, Line& line);

}  // namespace fresco::lbfgs
