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

/// The shares of the directions +x, -x, +y, -y, +z, -z; they sum to 1 and change smoothly with the normal.
std::array<float, 6> direction_shares(Vec3f normal)
{
    const auto share = [](float n) { return n > 0 ? n * n : 0.0F; };
    return {share(normal.x), share(-normal.x), share(normal.y), share(-normal.y), share(normal.z), share(-normal.z)};
}
}  // namespace

SurfaceAverage::SurfaceAverage(Vec3f low, Vec3f high, double wavelength_m)
    : low_(vec_cast<double>(low)), spacing_(wavelength_m / spacings_per_wavelength)
{
    constexpr double most_cells = 1e8;
    const Vec3d extent = vec_cast<double>(high) - low_;
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

template <class Use>
void SurfaceAverage::around(Vec3f point, Use use) const
{
    const Vec3d at = (vec_cast<double>(point) - low_) * (1 / spacing_);
    const std::array along{at.x, at.y, at.z};
    std::array<std::size_t, 3> first{};
    std::array<float, 3> share{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
        const double cell = std::clamp(std::floor(along[axis]), 0.0, static_cast<double>(cells_[axis] - 2));
        first[axis] = static_cast<std::size_t>(cell);
        share[axis] = static_cast<float>(along[axis] - cell);
    }
    for (std::size_t corner = 0; corner < 8; ++corner)
    {
        float weight = 1;
        std::size_t cell = 0;
        for (std::size_t axis = 3; axis-- > 0;)
        {
            const std::size_t step = corner >> axis & 1U;
            weight *= step == 1 ? share[axis] : 1 - share[axis];
            cell = cell * cells_[axis] + first[axis] + step;
        }
        use(cell, weight);
    }
}

void SurfaceAverage::add(Vec3f point, Vec3f normal, Vec3f color)
{
    const auto shares = direction_shares(normal);
    around(point,
           [&](std::size_t cell, float weight)
           {
               if (node_of_[cell] == none)
               {
                   node_of_[cell] = static_cast<std::uint32_t>(nodes_.size());
                   nodes_.emplace_back();
               }
               Node& node = nodes_[node_of_[cell]];
               for (std::size_t d = 0; d < shares.size(); ++d)
               {
                   const float w = weight * shares[d];
                   node[d][0] += w * color.x;
                   node[d][1] += w * color.y;
                   node[d][2] += w * color.z;
                   node[d][3] += w;
               }
           });
}

Vec3f SurfaceAverage::at(Vec3f point, Vec3f normal, Vec3f otherwise) const
{
    const auto shares = direction_shares(normal);
    Sum sum{};
    around(point,
           [&](std::size_t cell, float weight)
           {
               if (node_of_[cell] == none)
                   return;
               const Node& node = nodes_[node_of_[cell]];
               for (std::size_t d = 0; d < shares.size(); ++d)
                   for (std::size_t i = 0; i < sum.size(); ++i)
                       sum[i] += weight * shares[d] * node[d][i];
           });
    constexpr float least_weight = 1e-6F;
    return sum[3] > least_weight ? Vec3f{sum[0], sum[1], sum[2]} * (1 / sum[3]) : otherwise;
}
