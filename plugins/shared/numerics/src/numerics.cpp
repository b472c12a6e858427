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

double cosine_deg(double degrees)
{
    return std::cos(degrees * std::numbers::pi / 180);
}

std::vector<std::uint32_t> number_by_first(std::span<std::uint32_t> numbers, std::size_t end)
{
    constexpr std::uint32_t none = 0xffffffffU;
    std::vector<std::uint32_t> number_of(end, none);
    std::vector<std::uint32_t> stood_for;
    for (std::uint32_t& number : numbers)
    {
        if (number == none)
            continue;
        if (number_of[number] == none)
        {
            number_of[number] = static_cast<std::uint32_t>(stood_for.size());
            stood_for.push_back(number);
        }
        number = number_of[number];
    }
    return stood_for;
}

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

std::vector<Vec3d> spread_directions(std::size_t count)
{
    const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
    std::vector<Vec3d> directions;
    for (std::size_t i = 0; i < count; ++i)
    {
        const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count), radius = std::sqrt(1 - z * z);
        const double angle = golden_angle * static_cast<double>(i);
        directions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
    return directions;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> nearest_pairs(std::span<const double> a, std::span<const double> b)
{
    // Remaining points of the circle. The nearest pair is always adjacent: a point between its two would be nearer to one.
    std::vector<std::tuple<double, std::uint32_t, bool>> circle;  // Angle, index, of `a`.
    circle.reserve(a.size() + b.size());
    for (std::uint32_t i = 0; i < a.size(); ++i)
        circle.emplace_back(a[i], i, true);
    for (std::uint32_t i = 0; i < b.size(); ++i)
        circle.emplace_back(b[i], i, false);
    std::sort(circle.begin(), circle.end());
    const std::size_t count = circle.size();
    std::vector<std::size_t> next(count), previous(count);
    std::vector<bool> taken(count, false);

    using Gap = std::tuple<double, std::size_t, std::size_t>;  // Its angle and the directions before and behind it.
    std::priority_queue<Gap, std::vector<Gap>, std::greater<>> gaps;
    const auto look_at = [&](std::size_t first, std::size_t second)
    {
        const auto& [angle, index, of_a] = circle[first];
        const auto& [other_angle, other_index, other_of_a] = circle[second];
        const double around = std::abs(angle - other_angle);
        if (of_a != other_of_a)
            gaps.emplace(std::min(around, 2 * std::numbers::pi - around), first, second);
    };
    for (std::size_t i = 0; i < count; ++i)
    {
        next[i] = (i + 1) % count;
        previous[next[i]] = i;
        look_at(i, next[i]);
    }

    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    while (!gaps.empty())
    {
        const auto [angle, first, second] = gaps.top();
        gaps.pop();
        if (taken[first] || taken[second])
            continue;
        const auto index = std::get<1>(circle[first]);
        const auto other_index = std::get<1>(circle[second]);
        const bool of_a = std::get<2>(circle[first]);
        pairs.emplace_back(of_a ? index : other_index, of_a ? other_index : index);
        for (const std::size_t i : {first, second})
        {
            taken[i] = true;
            next[previous[i]] = next[i];
            previous[next[i]] = previous[i];
        }
        if (!taken[previous[first]] && !taken[next[second]])
            look_at(previous[first], next[second]);
    }
    return pairs;
}

}  // namespace fresco::numerics
