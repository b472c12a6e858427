#include "surface_average.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

using namespace fresco;

namespace
{
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// Linear weights on the way in and out make a cubic B-spline of the spacing h, whose response to the frequency f is sinc⁴(f h):
/// one half at f h = 0.32.
constexpr double spacings_per_wavelength = 1 / 0.32;

/// Of the directions +x, -x, +y, -y, +z, -z: the three that a normal leans to, and their shares, its squared length in all. They
/// change smoothly with the normal.
struct Directions
{
    std::array<std::size_t, 3> of;
    std::array<float, 3> share;
};

Directions directions(Vec3f normal)
{
    return {{normal.x > 0 ? 0U : 1U, normal.y > 0 ? 2U : 3U, normal.z > 0 ? 4U : 5U},
            {normal.x * normal.x, normal.y * normal.y, normal.z * normal.z}};
}
}  // namespace

SurfaceAverage::SurfaceAverage(Vec3f low, Vec3f high, double wavelength_m)
    : low_(low), spacing_(wavelength_m / spacings_per_wavelength)
{
    constexpr double most_cells = 1e8;
    const Vec3d extent = vec_cast<double>(high) - vec_cast<double>(low);
    double count = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
        // One more for the node behind the last point.
        const double along = std::floor(std::array{extent.x, extent.y, extent.z}[axis] / spacing_) + 2;
        count *= along;
        cells_[axis] = static_cast<std::size_t>(std::min(along, most_cells));
    }
    if (count > most_cells)
        throw Error(fmt::format("a mesh of {:.3g} x {:.3g} x {:.3g} m is too large for means over {:.3g} cm; increase split_cm",
                                extent.x, extent.y, extent.z, 100 * wavelength_m));
    node_of_.assign(cells_[0] * cells_[1] * cells_[2], none);
}

inline SurfaceAverage::Place SurfaceAverage::place(Vec3f point) const
{
    const Vec3f at = (point - low_) * static_cast<float>(1 / spacing_);
    const std::array along{at.x, at.y, at.z};
    Place result;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
        const int cell = std::clamp(static_cast<int>(along[axis]), 0, static_cast<int>(cells_[axis]) - 2);
        result.cell[axis] = static_cast<std::uint32_t>(cell);
        result.share[axis] = along[axis] - static_cast<float>(cell);
    }
    return result;
}

std::array<std::size_t, 8> SurfaceAverage::corners(const std::array<std::uint32_t, 3>& cell) const
{
    std::array<std::size_t, 8> result;
    for (std::size_t corner = 0; corner < 8; ++corner)
    {
        result[corner] = 0;
        for (std::size_t axis = 3; axis-- > 0;)
            result[corner] = result[corner] * cells_[axis] + cell[axis] + (corner >> axis & 1U);
    }
    return result;
}

inline std::array<float, 8> SurfaceAverage::weights(const std::array<float, 3>& share)
{
    const float x = share[0];
    const float far_far = share[1] * share[2];
    const float far_near = share[1] - far_far;
    const float near_far = share[2] - far_far;
    const float near_near = 1 - share[1] - near_far;
    return {near_near * (1 - x), near_near * x, far_near * (1 - x), far_near * x,
            near_far * (1 - x),  near_far * x,  far_far * (1 - x),  far_far * x};
}

void SurfaceAverage::add(Vec3f point, Vec3f normal, Vec3f color)
{
    const Directions to = directions(normal);
    const Sum sample{color.x, color.y, color.z, 1};
    const Place at = place(point);
    const auto cells = corners(at.cell);
    const auto weight = weights(at.share);
    for (std::size_t corner = 0; corner < 8; ++corner)
    {
        std::uint32_t& number = node_of_[cells[corner]];
        if (number == none)
        {
            number = static_cast<std::uint32_t>(nodes_.size());
            nodes_.emplace_back();
        }
        for (std::size_t i = 0; i < 3; ++i)
        {
            Sum& sum = nodes_[number][to.of[i]];
            sum += weight[corner] * to.share[i] * sample;
        }
    }
}

SurfaceAverage::Lookup::Lookup(const SurfaceAverage& average) : average_(average)
{
    cell_.fill(none);
}

Vec3f SurfaceAverage::Lookup::at(Vec3f point, Vec3f normal, Vec3f otherwise)
{
    static const Node empty{};
    const Place place = average_.place(point);
    if (place.cell != cell_)
    {
        cell_ = place.cell;
        const auto cells = average_.corners(cell_);
        for (std::size_t corner = 0; corner < 8; ++corner)
        {
            const std::uint32_t number = average_.node_of_[cells[corner]];
            nodes_[corner] = number == none ? &empty : &average_.nodes_[number];
        }
    }
    const Directions to = directions(normal);
    const auto weight = weights(place.share);
    Sum sum{};
    for (std::size_t i = 0; i < 3; ++i)
    {
        Sum around{};
        for (std::size_t corner = 0; corner < 8; ++corner)
            around += weight[corner] * (*nodes_[corner])[to.of[i]];
        sum += to.share[i] * around;
    }
    constexpr float least_weight = 1e-6F;
    return sum[3] > least_weight * dot(normal, normal) ? Vec3f{sum[0], sum[1], sum[2]} * (1 / sum[3]) : otherwise;
}
