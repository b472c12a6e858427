#include "size_by_distance.h"

#include <fresco/evaluation/statistics.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using evaluation::mean;

namespace
{
constexpr std::size_t least_places = 4;
constexpr double similar_color = 6;  // Sigma, CIE76.
/// Sigma, in sides, of how the common part of two squares' energies falls with their distance: the autocorrelation of the square
/// of their Hann window is nearly a Gaussian.
constexpr double shared_spread = 0.2;

/// Of the picture's squares, weighted by how similar their colors are.
double size_of_color(Vec3f color, const std::vector<ColoredSize>& picture)
{
    double sum = 0;
    double total = 0;
    for (const ColoredSize& square : picture)
    {
        const Vec3d apart = vec_cast<double>(square.color - color);
        // Far from all colors it is the picture's mean.
        const double weight = 1e-9 + std::exp(-dot(apart, apart) / (2 * similar_color * similar_color));
        sum += weight * square.size;
        total += weight;
    }
    return sum / total;
}

double product(const std::vector<double>& x, const std::vector<double>& y)
{
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        sum += x[i] * y[i];
    return sum;
}

std::vector<double> centered(std::vector<double> values)
{
    const double middle = mean(values);
    for (double& value : values)
        value -= middle;
    return values;
}

/// What is left of `values` when they are predicted from `control` by a straight line. \pre Both are centered.
std::vector<double> without(std::vector<double> values, const std::vector<double>& control)
{
    const double square = product(control, control);
    const double slope = square > 0 ? product(values, control) / square : 0;
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] -= slope * control[i];
    return values;
}

/// Variance of the correlation of two independent fields with the autocorrelations of `x` and `y`. \pre Both are centered.
/// Autocorrelations of few places are estimated too low, because their means are subtracted. So no more places count as
/// independent than the squares that do not overlap.
double chance_variance(const std::vector<PlacedSize>& places, const std::vector<double>& x, const std::vector<double>& y,
                       double side_m)
{
    struct Class
    {
        double x = 0, y = 0, pairs = 0;
    };
    std::vector<Class> classes;
    const auto count = static_cast<double>(places.size());
    double overlap = count;
    for (std::size_t i = 0; i < places.size(); ++i)
        for (std::size_t j = i + 1; j < places.size(); ++j)
        {
            const double apart = double{length(places[i].point - places[j].point)} / side_m;
            const auto index = static_cast<std::size_t>(4 * std::log2(1 + 2 * apart));
            if (index >= classes.size())
                classes.resize(index + 1);
            classes[index].x += 2 * x[i] * x[j];
            classes[index].y += 2 * y[i] * y[j];
            classes[index].pairs += 2;
            overlap += 2 * std::exp(-apart * apart / (2 * shared_spread * shared_spread));
        }
    // A place with itself is a class of its own, where both autocorrelations are 1.
    double sum = product(x, x) * product(y, y) / count;
    for (const Class& one : classes)
        if (one.pairs > 0)
            sum += one.x * one.y / one.pairs;
    return std::max(sum / (product(x, x) * product(y, y)), overlap / (count * count));
}
}  // namespace

SizeByDistance size_by_distance(const std::vector<PlacedSize>& places, const std::vector<ColoredSize>& picture, double side_m)
{
    SizeByDistance result;
    result.places = places.size();
    if (places.size() < least_places)
        return result;
    std::vector<double> sizes;
    std::vector<double> distances;
    std::vector<double> expected;
    for (const PlacedSize& place : places)
    {
        sizes.push_back(place.strokes.size);
        distances.push_back(place.distance);
        expected.push_back(size_of_color(place.strokes.color, picture));
    }
    expected = centered(std::move(expected));
    sizes = without(centered(std::move(sizes)), expected);
    distances = without(centered(std::move(distances)), expected);
    result.correlation = evaluation::pearson(sizes, distances);
    // Sizes that do depend on distance are as alike as distances; the rest says how far chance goes.
    const std::vector<double> rest = without(sizes, distances);
    if (!std::isnan(result.correlation))
        result.standard_error = std::sqrt(chance_variance(places, rest, distances, side_m));
    return result;
}
