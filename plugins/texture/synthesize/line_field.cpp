#include "line_field.h"

#include <fresco/error.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/Sparse>

#include <algorithm>
#include <cmath>

namespace fresco::synthesize
{
namespace
{

using Complex = std::complex<double>;

constexpr double least_hold = 1e-6;  // Toward nothing, of a face without a hint: what no hint reaches is defined.
constexpr double tolerance = 1e-4;
constexpr int most_iterations = 2000;

Vec3f middle(const Mesh& mesh, std::size_t face)
{
    const Triangle& t = mesh.triangles[face];
    return (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) * (1.0F / 3);
}

/// At most 1.
Complex limited(Complex hint)
{
    const double weight = std::abs(hint);
    return weight > 1 ? hint / weight : hint;
}

}  // namespace

LineHints::LineHints(const PaintedSurface& surface, const Upright& upright) : surface_(surface)
{
    for (const Vec3f normal : surface.normals)
        bases_.push_back(frame_at(normal, upright));
    up_ = upright.up;
}

Complex LineHints::coded(std::size_t face, Vec3f along) const
{
    const Complex z{double{dot(along, bases_[face].right)}, double{dot(along, bases_[face].down)}};
    return z * z;
}

Vec3f LineHints::edge(std::size_t face, std::size_t corner) const
{
    const Triangle& t = surface_.mesh.triangles[face];
    return surface_.mesh.positions[t[(corner + 1) % 3]] - surface_.mesh.positions[t[corner]];
}

std::vector<Complex> LineHints::gravity() const
{
    std::vector<Complex> hints(bases_.size());
    for (std::size_t f = 0; f < hints.size(); ++f)
        hints[f] = coded(f, up_);
    return hints;
}

std::vector<Complex> LineHints::curvature(double radius_m) const
{
    std::vector<Complex> hints(bases_.size());
    for (std::size_t f = 0; f < hints.size(); ++f)
    {
        const Vec3f normal = surface_.normals[f];
        const double around = surface_.areas[f];
        // How the normal changes along the face: means over its edges, times their outward normals (the divergence theorem).
        double xx = 0, xy = 0, yy = 0;
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const std::uint32_t other = surface_.neighbors[f][corner];
            if (other == geometry::none)
                continue;
            const Vec3f change = (surface_.normals[other] - normal) * 0.5F;
            const Vec3f out = cross(edge(f, corner), normal);
            const auto along = [&](Vec3f v) { return Vec2d{double{dot(v, bases_[f].right)}, double{dot(v, bases_[f].down)}}; };
            const Vec2d n = along(change);
            const Vec2d e = along(out);
            xx += n.x * e.x;
            xy += (n.x * e.y + n.y * e.x) / 2;
            yy += n.y * e.y;
        }
        if (around > 0)
            hints[f] = limited(Complex{yy - xx, -2 * xy} * (std::copysign(radius_m, xx + yy) / around));
    }
    return hints;
}

std::vector<Complex> LineHints::drawn(const Texture& lines, const Progress& progress) const
{
    texturing::check_texture(lines);
    const Mesh& mesh = surface_.mesh;
    const RasterF rgb = texturing::collapse(lines, progress);
    const texturing::TexelFaces faces = texturing::find_texel_faces(mesh, surface_.charts, rgb.width, progress);
    const auto light = [&](std::size_t texel)
    {
        const float* v = &rgb.values[3 * texel];
        return double{0.2126F * v[0] + 0.7152F * v[1] + 0.0722F * v[2]};
    };
    std::vector<Complex> hints(bases_.size());
    std::vector<double> counts(bases_.size(), 0.0);
    const auto width = static_cast<std::size_t>(rgb.width);
    for (std::size_t y = 1; y + 1 < width; ++y)
        for (std::size_t x = 1; x + 1 < width; ++x)
        {
            const std::size_t texel = y * width + x;
            if (faces.inside[texel] == 0)
                continue;
            const std::uint32_t face = faces.face[texel];
            const std::uint32_t chart = surface_.charts.of_face[face];
            const auto usable = [&](std::size_t other) {
                return faces.covered(other) && surface_.charts.of_face[faces.face[other]] == chart &&
                       lines.seen.values[other] != 0;
            };
            if (!usable(texel) || !usable(texel - 1) || !usable(texel + 1) || !usable(texel - width) || !usable(texel + width))
                continue;
            const double du = light(texel + 1) - light(texel - 1);
            const double dv = light(texel - width) - light(texel + width);
            const auto [u, v] = texcoord_axes(mesh, face);
            // Perpendicular to the gradient g, which has g·u = du and g·v = dv, lies u dv - v du.
            const double per_m = 1 / std::max(double{length(cross(u, v))}, 1e-30);
            hints[face] += coded(face, (u * static_cast<float>(dv) - v * static_cast<float>(du)) * static_cast<float>(per_m));
            ++counts[face];
        }
    double sum = 0;
    double count = 0;
    for (std::size_t f = 0; f < hints.size(); ++f)
        if (counts[f] > 0)
        {
            sum += std::abs(hints[f]);
            count += counts[f];
            hints[f] /= counts[f];
        }
    if (!(sum > 0))
        throw Error(
            "the texture on port 'lines' has no lines: it shows the mesh a single color, or nothing; draw lines along which "
            "strokes should run");
    for (Complex& hint : hints)
        hint = limited(hint * (count / sum));
    return hints;
}

std::vector<Vec3f> LineHints::smoothed(const std::vector<Complex>& hints, double reach_m, const Progress& progress) const
{
    const Mesh& mesh = surface_.mesh;
    const auto count = static_cast<Eigen::Index>(hints.size());
    std::vector<Eigen::Triplet<Complex>> entries;
    Eigen::VectorXcd right(count);
    for (std::size_t f = 0; f < hints.size(); ++f)
    {
        if (f % 4096 == 0)
            progress.check_canceled();
        const auto row = static_cast<Eigen::Index>(f);
        const double a = surface_.areas[f] / (reach_m * reach_m);
        double diagonal = a * (std::abs(hints[f]) + least_hold) + 1e-12;
        right[row] = a * hints[f];
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const std::uint32_t other = surface_.neighbors[f][corner];
            if (other == geometry::none)
                continue;
            const Vec3f along = edge(f, corner);
            const Complex here = coded(f, along);
            const Complex there = coded(other, along);
            const double apart = double{length(middle(mesh, f) - middle(mesh, other))};
            if (std::abs(here) <= 0 || std::abs(there) <= 0 || apart <= 0)
                continue;
            const double weight = double{length(along)} / apart;
            diagonal += weight;
            entries.emplace_back(row, static_cast<Eigen::Index>(other),
                                 -weight * (here / std::abs(here)) * std::conj(there / std::abs(there)));
        }
        entries.emplace_back(row, row, diagonal);
    }
    Eigen::SparseMatrix<Complex, Eigen::RowMajor> matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::ConjugateGradient<Eigen::SparseMatrix<Complex, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(tolerance);
    solver.setMaxIterations(most_iterations);
    solver.compute(matrix);
    progress.check_canceled();
    const Eigen::VectorXcd solved = solver.solve(right);

    std::vector<Vec3f> lines;
    for (std::size_t f = 0; f < hints.size(); ++f)
    {
        const Complex z = std::sqrt(solved[static_cast<Eigen::Index>(f)]);
        const double size = std::abs(z);
        const Complex unit = size > 0 && std::isfinite(size) ? z / size : Complex{1, 0};
        lines.push_back(bases_[f].right * static_cast<float>(unit.real()) + bases_[f].down * static_cast<float>(unit.imag()));
    }
    return lines;
}

}  // namespace fresco::synthesize
