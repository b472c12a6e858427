#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <numbers>
#include <queue>
#include <tuple>

namespace fresco::numerics
{

void sort_by_upper_half(std::vector<std::uint64_t>& entries, std::uint32_t largest)
{
    constexpr unsigned digit_bits = 11;
    constexpr std::size_t buckets = std::size_t{1} << digit_bits;
    std::vector<std::uint64_t> sorted(entries.size());
    for (unsigned shift = 0; shift < 32 && (largest >> shift) != 0; shift += digit_bits)
    {
        const auto digit = [shift](std::uint64_t entry)
        { return static_cast<std::size_t>(entry >> (32 + shift)) & (buckets - 1); };
        std::array<std::size_t, buckets + 1> starts{};
        for (const auto entry : entries)
            ++starts[digit(entry) + 1];
        for (std::size_t i = 1; i <= buckets; ++i)
            starts[i] += starts[i - 1];
        for (const auto entry : entries)
            sorted[starts[digit(entry)]++] = entry;
        entries.swap(sorted);
    }
}

double median(std::vector<double> values)
{
    const auto middle = values.begin() + std::ssize(values) / 2;
    std::ranges::nth_element(values, middle);
    return *middle;
}

void solve_symmetric(std::span<double> matrix, std::span<double> right, std::size_t columns)
{
    const std::size_t n = right.size() / columns;
    const auto at = [&](std::size_t row, std::size_t column) -> double& { return matrix[row * n + column]; };
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j)
        {
            double sum = at(i, j);
            for (std::size_t k = 0; k < j; ++k)
                sum -= at(i, k) * at(j, k);
            at(i, j) = i == j ? std::sqrt(sum) : sum / at(j, j);
        }
    for (std::size_t c = 0; c < columns; ++c)
    {
        const auto x = [&](std::size_t row) -> double& { return right[row * columns + c]; };
        for (std::size_t i = 0; i < n; ++i)
        {
            for (std::size_t k = 0; k < i; ++k)
                x(i) -= at(i, k) * x(k);
            x(i) /= at(i, i);
        }
        for (std::size_t i = n; i-- > 0;)
        {
            for (std::size_t k = i + 1; k < n; ++k)
                x(i) -= at(k, i) * x(k);
            x(i) /= at(i, i);
        }
    }
}

Mat3 rotation_by(Vec3d turn)
{
    const double angle = length(turn);
    const Vec3d axis = normalized(turn);
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    const double r = 1 - c;
    return {{c + axis.x * axis.x * r, axis.x * axis.y * r - axis.z * s, axis.x * axis.z * r + axis.y * s,
             axis.y * axis.x * r + axis.z * s, c + axis.y * axis.y * r, axis.y * axis.z * r - axis.x * s,
             axis.z * axis.x * r - axis.y * s, axis.z * axis.y * r + axis.x * s, c + axis.z * axis.z * r}};
}

Mat3 rotation_of(double w, double x, double y, double z)
{
    return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z), 1 - 2 * (x * x + z * z),
             2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
}

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

}  // namespace fresco::numerics
