#include "line_search.h"

#include <algorithm>
#include <cmath>

namespace fresco::lbfgs
{
namespace
{

bool finite(const Sample& sample)
{
    return std::isfinite(sample.value) && std::isfinite(sample.slope);
}

/// Where the cubic through two points with these slopes has its minimum (equation 3.59); NaN where it has none.
double cubic_minimum(const Sample& a, const Sample& b)
{
    const double width = b.step - a.step;
    const double first = a.slope + b.slope - 3 * (a.value - b.value) / (a.step - b.step);
    const double second = std::copysign(std::sqrt(first * first - a.slope * b.slope), width);
    return b.step - width * (b.slope + second - first) / (b.slope - a.slope + 2 * second);
}

class Search
{
  public:
    Search(const Sample& start, const SearchOptions& options, Line& line)
        : start_(start), options_(options), line_(line), left_(options.max_evaluations)
    {
    }

    Sample halving(double step)
    {
        while (left_ > 0)
        {
            const auto sample = evaluate(step);
            if (sufficient(sample))
                return kept(sample);
            step /= 2;
        }
        return start_;
    }

    /// Algorithm 3.5.
    Sample bracketing(double step)
    {
        Sample previous = start_;
        while (left_ > 0)
        {
            const auto sample = evaluate(step);
            if (!sufficient(sample) || (previous.step > 0 && sample.value >= previous.value))
                return zoom(previous, sample);
            line_.keep();
            if (flat(sample) || sample.step >= options_.longest)
                return sample;
            if (sample.slope >= 0)
                return zoom(sample, previous);
            const double wanted = cubic_minimum(previous, sample);
            step = std::isfinite(wanted) ? std::clamp(wanted, 1.5 * sample.step, 5 * sample.step) : 2 * sample.step;
            step = std::min(step, options_.longest);
            previous = sample;
        }
        return previous;
    }

  private:
    Sample evaluate(double step)
    {
        --left_;
        return line_.at(step);
    }

    Sample kept(const Sample& sample)
    {
        line_.keep();
        return sample;
    }

    bool sufficient(const Sample& sample) const
    {
        return finite(sample) && sample.value <= start_.value + options_.sufficient * sample.step * start_.slope;
    }

    bool flat(const Sample& sample) const { return std::abs(sample.slope) <= -options_.curvature * start_.slope; }

    /// Algorithm 3.6: `low` has the smallest value so far and slopes down toward `high`.
    Sample zoom(Sample low, Sample high)
    {
        while (left_ > 0)
        {
            const double width = high.step - low.step;
            double step = low.step + width / 2;
            const double wanted = finite(high) ? cubic_minimum(low, high) : step;
            if (std::isfinite(wanted))
                step = std::clamp(wanted, std::min(low.step + 0.1 * width, low.step + 0.9 * width),
                                  std::max(low.step + 0.1 * width, low.step + 0.9 * width));
            const auto sample = evaluate(step);
            if (!sufficient(sample) || sample.value >= low.value)
            {
                high = sample;
                continue;
            }
            line_.keep();
            if (flat(sample))
                return sample;
            if (sample.slope * width >= 0)
                high = low;
            low = sample;
        }
        return low;
    }

    Sample start_;
    SearchOptions options_;
    Line& line_;
    int left_;
};

}  // namespace

Sample line_search(const Sample& start, double first, const SearchOptions& options, Line& line)
{
    Search search(start, options, line);
    const double step = std::min(first, options.longest);
    return options.strong_wolfe ? search.bracketing(step) : search.halving(step);
}

}  // namespace fresco::lbfgs
