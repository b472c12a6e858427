#include <fresco/error.h>
#include <fresco/numerics/numerics.h>
#include <fresco/texturing/surface_average.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace fresco::texturing
{

namespace
{

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// Linear weights on the way in and out make a cubic B-spline of the spacing h, whose response to the frequency f is sinc⁴(f h):
/// one half at f h = 0.32.
constexpr double spacings_per_wavelength = 1 / 0.32;

/// The three of the directions +x, -x, +y, -y, +z, -z that a normal leans to, and their shares, which sum to its squared length.
/// They change smoothly with the normal.
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

SurfaceAverage::SurfaceAverage(Vec3f low, Vec3f high, double wavelength_m, std::string_view option)
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
        throw Error(fmt::format("a mesh of {:.3g} x {:.3g} x {:.3g} m is too large for means over {:.3g} cm; increase {}",
                                extent.x, extent.y, extent.z, 100 * wavelength_m, option));
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

namespace
{

/// The weights of a face's corners at texel centers along a row, as texel_weights gives them: they change by equal steps.
class FaceRow
{
  public:
    FaceRow(const Mesh& mesh, const TexelFaces& faces, std::size_t first)
    {
        const auto size = static_cast<std::size_t>(faces.size);
        const Vec2d center{static_cast<double>(first % size) + 0.5, static_cast<double>(first / size) + 0.5};
        std::array<Vec2d, 3> to;
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec2f uv = mesh.texcoords[3 * std::size_t{faces.face[first]} + i];
            to[i] = Vec2d{double{uv.x} * faces.size, (1 - double{uv.y}) * faces.size} - center;
        }
        const double area = cross(to[1] - to[0], to[2] - to[0]);
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec2d a = to[(i + 1) % 3];
            const Vec2d b = to[(i + 2) % 3];
            first_[i] = area == 0 ? 1.0 / 3 : cross(a, b) / area;
            step_[i] = area == 0 ? 0 : (a.y - b.y) / area;
        }
    }

    /// The centers of this many texels are inside the face.
    bool holds(std::size_t count) const
    {
        const double last = static_cast<double>(count - 1);
        for (std::size_t i = 0; i < 3; ++i)
            if (std::min(first_[i], first_[i] + last * step_[i]) < 0)
                return false;
        return true;
    }

    std::array<double, 3> at(std::size_t texels_on) const
    {
        std::array<double, 3> weights;
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i)
            sum += weights[i] = std::max(first_[i] + static_cast<double>(texels_on) * step_[i], 0.0);
        for (double& w : weights)
            w /= sum;
        return weights;
    }

    /// As long as the face holds the centers, what its corners have changes by this from one texel to the next.
    const std::array<double, 3>& step() const { return step_; }

  private:
    std::array<double, 3> first_;
    std::array<double, 3> step_;
};

}  // namespace

TexelMeans::TexelMeans(const Mesh& mesh, const TexelFaces& faces, std::function<Vec3f(std::size_t)> value)
    : mesh_(mesh), faces_(faces), value_(std::move(value)), normals_(smooth_normals(mesh))
{
}

SurfaceAverage TexelMeans::averaged(double wavelength_m, std::string_view option, const Progress& progress) const
{
    numerics::Bounds<float> box;
    for (const Vec3f p : mesh_.positions)
        box.add(p);
    SurfaceAverage average(box.low, box.high, wavelength_m, option);
    // Many samples in each cell are enough; all of a large texture's would only take longer.
    constexpr double samples_per_spacing = 8;
    const auto stride = static_cast<std::size_t>(
        std::clamp(average.spacing_m() / mean_texel_m(mesh_, faces_.size) / samples_per_spacing, 1.0, 16.0));
    const auto size = static_cast<std::size_t>(faces_.size);
    for (std::size_t y = 0; y < size; y += stride)
    {
        progress.check_canceled();
        for (std::size_t texel = y * size; texel < (y + 1) * size; texel += stride)
            if (faces_.inside[texel])
            {
                const auto at = place(texel);
                average.add(at.point, at.normal, value_(texel));
            }
    }
    return average;
}

void TexelMeans::each_row(double wavelength_m, std::string_view option, const Progress& progress,
                          const std::function<void(std::size_t, std::vector<float>&)>& visit) const
{
    const SurfaceAverage average = averaged(wavelength_m, option, progress);
    const auto size = static_cast<std::size_t>(faces_.size);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(size, rows_per_block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     SurfaceAverage::Lookup lookup(average);
                     std::vector<float> mean(3 * size);
                     for (std::size_t row = begin; row < end; ++row)
                     {
                         mean_of_row(row, lookup, mean);
                         visit(row, mean);
                     }
                 });
}

void TexelMeans::mean_of_row(std::size_t row, SurfaceAverage::Lookup& mean, std::vector<float>& result) const
{
    std::ranges::fill(result, 0.0F);
    const auto size = static_cast<std::size_t>(faces_.size);
    const std::size_t end = (row + 1) * size;
    for (std::size_t texel = row * size; texel < end;)
    {
        const std::size_t first = texel;
        const std::uint32_t face = faces_.face[first];
        while (texel < end && faces_.face[texel] == face)
            ++texel;
        if (face != TexelFaces::none)
            mean_of(first, texel, mean, &result[3 * (first - row * size)]);
    }
}

/// At the texels first … end - 1, all of one row and one face.
void TexelMeans::mean_of(std::size_t first, std::size_t end, SurfaceAverage::Lookup& mean, float* result) const
{
    const FaceRow row(mesh_, faces_, first);
    const Triangle& corners = mesh_.triangles[faces_.face[first]];
    const auto weighted = [&](const std::array<double, 3>& weights)
    {
        Place sum;
        for (std::size_t i = 0; i < 3; ++i)
        {
            sum.point += mesh_.positions[corners[i]] * static_cast<float>(weights[i]);
            sum.normal += normals_[corners[i]] * static_cast<float>(weights[i]);
        }
        return sum;
    };
    const auto look_up = [&](std::size_t texel, const Place& at)
    {
        const Vec3f color = mean.at(at.point, at.normal, value_(texel));
        *result++ = color.x;
        *result++ = color.y;
        *result++ = color.z;
    };
    if (!row.holds(end - first))
    {
        for (std::size_t texel = first; texel < end; ++texel)
            look_up(texel, weighted(row.at(texel - first)));
        return;
    }
    const Place begin = weighted(row.at(0));
    const Place step = weighted(row.step());
    for (std::size_t texel = first; texel < end; ++texel)
    {
        const auto on = static_cast<float>(texel - first);
        look_up(texel, {begin.point + step.point * on, begin.normal + step.normal * on});
    }
}

TexelMeans::Place TexelMeans::place(std::size_t texel) const
{
    const auto weights = texel_weights(mesh_, faces_, texel);
    const Triangle& corners = mesh_.triangles[faces_.face[texel]];
    Vec3d point;
    Vec3d normal;
    for (std::size_t i = 0; i < 3; ++i)
    {
        point += vec_cast<double>(mesh_.positions[corners[i]]) * weights[i];
        normal += vec_cast<double>(normals_[corners[i]]) * weights[i];
    }
    return {vec_cast<float>(point), vec_cast<float>(normalized(normal))};
}

}  // namespace fresco::texturing
