#include "nearest_pairs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>
#include <tuple>

namespace fresco::geometry
{
namespace
{

struct Direction
{
    double angle;
    std::uint32_t index;
    bool of_a;
};

/// Two directions of different sets that follow each other on the circle.
struct Gap
{
    double angle;
    std::size_t first, second;
    bool operator>(const Gap& other) const { return std::tie(angle, first) > std::tie(other.angle, other.first); }
};

/// What is left of the circle. The nearest pair always stands side by side: anything between its two would be nearer to one.
class Circle
{
  public:
    explicit Circle(std::vector<Direction> directions)
        : directions_(std::move(directions)), next_(directions_.size()), previous_(directions_.size()),
          taken_(directions_.size(), false)
    {
        std::sort(directions_.begin(), directions_.end(),
                  [](const Direction& x, const Direction& y)
                  { return std::tie(x.angle, x.index, x.of_a) < std::tie(y.angle, y.index, y.of_a); });
        const std::size_t count = directions_.size();
        for (std::size_t i = 0; i < count; ++i)
        {
            next_[i] = (i + 1) % count;
            previous_[next_[i]] = i;
        }
        for (std::size_t i = 0; i < count; ++i)
            look_at(i, next_[i]);
    }

    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs()
    {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> result;
        while (!gaps_.empty())
        {
            const auto [angle, first, second] = gaps_.top();
            gaps_.pop();
            if (taken_[first] || taken_[second])
                continue;
            const auto& x = directions_[first];
            const auto& y = directions_[second];
            result.emplace_back(x.of_a ? x.index : y.index, x.of_a ? y.index : x.index);
            take(first);
            take(second);
            if (!taken_[previous_[first]] && !taken_[next_[second]])
                look_at(previous_[first], next_[second]);
        }
        return result;
    }

  private:
    void take(std::size_t i)
    {
        taken_[i] = true;
        next_[previous_[i]] = next_[i];
        previous_[next_[i]] = previous_[i];
    }

    void look_at(std::size_t first, std::size_t second)
    {
        if (directions_[first].of_a == directions_[second].of_a)
            return;
        const double around = std::abs(directions_[first].angle - directions_[second].angle);
        gaps_.push({std::min(around, 2 * std::numbers::pi - around), first, second});
    }

    std::vector<Direction> directions_;
    std::vector<std::size_t> next_, previous_;
    std::vector<bool> taken_;
    std::priority_queue<Gap, std::vector<Gap>, std::greater<>> gaps_;
};

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> nearest_pairs(std::span<const double> a, std::span<const double> b)
{
    std::vector<Direction> directions;
    directions.reserve(a.size() + b.size());
    for (std::uint32_t i = 0; i < a.size(); ++i)
        directions.push_back({a[i], i, true});
    for (std::uint32_t i = 0; i < b.size(); ++i)
        directions.push_back({b[i], i, false});
    return Circle(std::move(directions)).pairs();
}

}  // namespace fresco::geometry
