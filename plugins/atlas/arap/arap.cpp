#include "arap.h"

#define EIGEN_MPL2_ONLY
#include <Eigen/SparseCholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace
{

using fresco::Vec2d;
using Matrix = Eigen::SparseMatrix<double>;

constexpr int most_rounds = 40;
/// Rounds end where the energy falls by less than this share.
constexpr double smallest_gain = 1e-3;
/// Cotangents are kept within these: obtuse corners would make the system indefinite, slivers stiff.
constexpr double least_weight = 0.01;
constexpr double largest_weight = 100;

/// A face in its own plane.
struct Face
{
    std::array<Vec2d, 3> edges{};     ///< From corner k to the next.
    std::array<double, 3> weights{};  ///< Weights of these edges: half the cotangent of the angle opposite.
};

Face face_of(const fresco::geometry::Disk& disk, const fresco::Triangle& t)
{
    const auto along = disk.points[t[1]] - disk.points[t[0]];
    const auto side = disk.points[t[2]] - disk.points[t[0]];
    const double base = length(along);
    const double twice = length(cross(along, side));
    const Vec2d right{base, 0};
    const Vec2d apex = base > 0 ? Vec2d{dot(side, along) / base, twice / base} : Vec2d{length(side), 0};
    Face face{{right, apex - right, apex * -1}, {}};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const double cosine = -dot(face.edges[(k + 1) % 3], face.edges[(k + 2) % 3]);
        face.weights[k] = std::clamp(0.5 * cosine / std::max(twice, 1e-300), least_weight, largest_weight);
    }
    return face;
}

/// The rotation, as a complex number, that takes a face's own edges nearest to where they lie; `energy` grows by what remains.
Vec2d best_turn(const Face& face, const fresco::Triangle& t, const std::vector<Vec2d>& places, double& energy)
{
    Vec2d sum{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto laid = places[t[(k + 1) % 3]] - places[t[k]];
        const auto e = face.edges[k];
        sum = sum + Vec2d{dot(e, laid), cross(e, laid)} * face.weights[k];
        energy += face.weights[k] * (dot(e, e) + dot(laid, laid));
    }
    const double size = length(sum);
    energy -= 2 * size;
    return size > 0 ? sum * (1 / size) : Vec2d{1, 0};
}

/// Laplacian of all vertices but the first, which is fixed.
Matrix laplacian(const fresco::geometry::Disk& disk, const std::vector<Face>& faces)
{
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(12 * faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const int a = static_cast<int>(disk.triangles[f][k]) - 1;
            const int b = static_cast<int>(disk.triangles[f][(k + 1) % 3]) - 1;
            const double w = faces[f].weights[k];
            if (a >= 0)
                entries.emplace_back(a, a, w);
            if (b >= 0)
                entries.emplace_back(b, b, w);
            if (a >= 0 && b >= 0)
            {
                entries.emplace_back(a, b, -w);
                entries.emplace_back(b, a, -w);
            }
        }
    const auto count = static_cast<Eigen::Index>(disk.points.size()) - 1;
    Matrix matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

}  // namespace

std::optional<std::vector<Vec2d>> arap_map(const fresco::geometry::Disk& disk, const std::vector<Vec2d>& from)
{
    if (disk.points.size() < 3)
        return std::nullopt;
    std::vector<Face> faces;
    faces.reserve(disk.triangles.size());
    for (const auto& t : disk.triangles)
        faces.push_back(face_of(disk, t));
    const Eigen::SimplicialLDLT<Matrix> solver(laplacian(disk, faces));
    if (solver.info() != Eigen::Success)
        return std::nullopt;

    auto places = from;
    const auto origin = places.front();
    for (auto& p : places)
        p = p - origin;
    double before = 0;
    for (int round = 0; round < most_rounds; ++round)
    {
        double energy = 0;
        Eigen::MatrixX2d pull = Eigen::MatrixX2d::Zero(static_cast<Eigen::Index>(places.size()), 2);
        for (std::size_t f = 0; f < faces.size(); ++f)
        {
            const auto& t = disk.triangles[f];
            const auto turn = best_turn(faces[f], t, places, energy);
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto e = faces[f].edges[k] * faces[f].weights[k];
                const Eigen::RowVector2d turned(turn.x * e.x - turn.y * e.y, turn.y * e.x + turn.x * e.y);
                pull.row(t[(k + 1) % 3]) += turned;
                pull.row(t[k]) -= turned;
            }
        }
        if (!std::isfinite(energy))
            return std::nullopt;
        if (round > 0 && energy > (1 - smallest_gain) * before)
            break;
        before = energy;
        const Eigen::MatrixX2d solved = solver.solve(pull.bottomRows(pull.rows() - 1));
        for (std::size_t v = 1; v < places.size(); ++v)
        {
            const auto row = static_cast<Eigen::Index>(v) - 1;
            places[v] = {solved(row, 0), solved(row, 1)};
        }
    }
    return places;
}
