#include "relaxation.h"

#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace fresco::geometry
{
namespace
{

/// Thinner faces count as this thin (height over longest side), or their gradients have no bounds.
constexpr double thinnest = 1e-3;
/// Untangled patches stop where a sweep gains less than this share of their energy.
constexpr double smallest_gain = 1e-3;
constexpr int halvings = 10;

/// The map from a face's own plane to the atlas: a column-wise 2 x 2 matrix, linear in the places of its corners.
struct Jacobian
{
    Vec2d first, second;  ///< Images of the axes of the face's plane.
    double determinant() const { return cross(first, second); }
    double square() const { return dot(first, first) + dot(second, second); }
};

/// A face in its own plane.
struct Element
{
    double area = 0;
    std::array<Vec2d, 3> gradients{};  ///< Gradients of the corners' hat functions.
};

Element element_of(const Vec3d* corners)
{
    const Vec3d along = corners[1] - corners[0];
    const Vec3d side = corners[2] - corners[0];
    const double base = length(along);
    Element element;
    if (!(base > 0))
        return element;
    const double longest = std::max({base, length(side), length(corners[2] - corners[1])});
    const Vec2d apex{dot(side, along) / base, std::max(length(cross(along, side)) / base, thinnest * longest)};
    const std::array<Vec2d, 3> t{Vec2d{0, 0}, Vec2d{base, 0}, apex};
    const double twice = base * apex.y;
    element.area = 0.5 * twice;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vec2d opposite = t[(k + 2) % 3] - t[(k + 1) % 3];
        element.gradients[k] = Vec2d{-opposite.y, opposite.x} * (1 / twice);
    }
    return element;
}

class Relaxer
{
  public:
    explicit Relaxer(FlatPatch& patch)
        : patch_(patch), around_(patch.places.size(),
                                 [&](const auto& add)
                                 {
                                     for (std::uint32_t h = 0; h < 3 * patch.triangles.size(); ++h)
                                         add(patch.triangles[h / 3][h % 3], h);
                                 })
    {
        for (std::size_t f = 0; f < patch.triangles.size(); ++f)
            elements_.push_back(element_of(&patch.points[3 * f]));
    }

    void run(int sweeps)
    {
        double before = std::numeric_limits<double>::infinity();
        for (int sweep = 0; sweep < sweeps; ++sweep)
        {
            const double least = least_determinant();
            epsilon_ = least > 0 ? 0 : std::sqrt(1e-6 + 0.04 * least * least);
            for (std::size_t v = 0; v < patch_.places.size(); ++v)
                if (patch_.movable[v])
                    step(v);
            const double now = energy();
            if (least > 0 && now > (1 - smallest_gain) * before)
                break;
            before = least > 0 ? now : std::numeric_limits<double>::infinity();
        }
    }

    PatchFigures figures() const
    {
        PatchFigures figures{least_determinant(), 0};
        double area = 0;
        for (std::size_t f = 0; f < elements_.size(); ++f)
        {
            if (!(elements_[f].area > 0))
                continue;
            const auto j = jacobian(f);
            const double d = j.determinant();
            // The inverse's squared singular values sum up to |J|² / det².
            figures.square_stretch += elements_[f].area * j.square() / (2 * d * d);
            area += elements_[f].area;
        }
        figures.square_stretch = area > 0 ? figures.square_stretch / area : 1;
        return figures;
    }

  private:
    Jacobian jacobian(std::size_t f) const
    {
        Jacobian j;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto p = patch_.places[patch_.triangles[f][k]];
            const auto g = elements_[f].gradients[k];
            j.first = j.first + p * g.x;
            j.second = j.second + p * g.y;
        }
        return j;
    }

    double least_determinant() const
    {
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t f = 0; f < elements_.size(); ++f)
            if (elements_[f].area > 0)
                least = std::min(least, jacobian(f).determinant());
        return least;
    }

    /// Positive everywhere; the determinant itself once nothing is folded.
    double barrier(double determinant) const
    {
        return epsilon_ > 0 ? 0.5 * (determinant + std::hypot(epsilon_, determinant)) : determinant;
    }

    double energy_of(const Jacobian& j) const
    {
        const double d = j.determinant();
        const double positive = barrier(d);
        return positive > 0 ? (j.square() + 1 + d * d) / positive : std::numeric_limits<double>::infinity();
    }

    /// A face without area has no shape to keep.
    double weighted_energy(std::size_t f) const { return elements_[f].area > 0 ? elements_[f].area * energy_of(jacobian(f)) : 0; }

    double energy() const
    {
        double sum = 0;
        for (std::size_t f = 0; f < elements_.size(); ++f)
            sum += weighted_energy(f);
        return sum;
    }

    double energy_around(std::size_t vertex) const
    {
        double sum = 0;
        for (const std::uint32_t h : around_[vertex])
            sum += weighted_energy(h / 3);
        return sum;
    }

    /// One Newton step with the barrier's slope held fixed, which keeps the Hessian positive, halved until the energy falls.
    void step(std::size_t vertex)
    {
        double value = 0;
        Vec2d gradient{};
        double xx = 0, xy = 0, yy = 0;
        for (const std::uint32_t h : around_[vertex])
        {
            const auto f = h / 3;
            const auto& element = elements_[f];
            const auto g = element.gradients[h % 3];
            const auto j = jacobian(f);
            const double d = j.determinant();
            const double positive = barrier(d);
            if (!(element.area > 0) || !(positive > 0))
                continue;
            const double slope = epsilon_ > 0 ? positive / std::hypot(epsilon_, d) : 1;
            const Vec2d of_d{g.x * j.second.y - g.y * j.first.y, g.y * j.first.x - g.x * j.second.x};
            const double top = j.square() + 1 + d * d;
            const Vec2d of_top = (j.first * g.x + j.second * g.y) * 2 + of_d * (2 * d);
            value += element.area * top / positive;
            gradient = gradient + (of_top - of_d * (top * slope / positive)) * (element.area / positive);
            const double same = element.area * 2 * dot(g, g) / positive;
            const double along = element.area * (2 + 2 * top * slope * slope / (positive * positive)) / positive;
            const double mixed = -element.area * slope / (positive * positive);
            xx += same + along * of_d.x * of_d.x + 2 * mixed * of_top.x * of_d.x;
            yy += same + along * of_d.y * of_d.y + 2 * mixed * of_top.y * of_d.y;
            xy += along * of_d.x * of_d.y + mixed * (of_top.x * of_d.y + of_top.y * of_d.x);
        }
        const double determinant = xx * yy - xy * xy;
        if (!(determinant > 0))
            return;
        const auto old = patch_.places[vertex];
        Vec2d move{-(yy * gradient.x - xy * gradient.y) / determinant, -(xx * gradient.y - xy * gradient.x) / determinant};
        for (int i = 0; i < halvings; ++i, move = move * 0.5)
        {
            patch_.places[vertex] = old + move;
            if (energy_around(vertex) < value)
                return;
        }
        patch_.places[vertex] = old;
    }

    FlatPatch& patch_;
    numerics::Buckets around_;  ///< Corners (3 x face + k) by vertex.
    std::vector<Element> elements_;
    double epsilon_ = 0;
};

}  // namespace

PatchFigures relax(FlatPatch& patch, int sweeps)
{
    Relaxer relaxer(patch);
    relaxer.run(sweeps);
    return relaxer.figures();
}

}  // namespace fresco::geometry
