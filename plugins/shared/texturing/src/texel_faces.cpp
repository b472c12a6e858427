#include <fresco/error.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/texturing/face_frame.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

namespace fresco::texturing
{

namespace
{
/// V: the lowest index of the vertices at the same position.
std::vector<std::uint32_t> welded_vertices(const Mesh& mesh)
{
    const auto key = [&](std::uint32_t v)
    {
        const Vec3f p = mesh.positions[v];
        return std::tuple(p.x, p.y, p.z);
    };
    return numerics::first_equal(mesh.positions.size(), key);
}

Mesh joined(const Mesh& mesh, const std::vector<std::uint32_t>& first)
{
    Mesh result;
    result.positions = mesh.positions;
    result.triangles = mesh.triangles;
    for (Triangle& triangle : result.triangles)
        for (std::uint32_t& corner : triangle)
            corner = first[corner];
    return result;
}

/// A face's side, its ends ordered by vertex.
struct Side
{
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    std::uint32_t face = 0;
    std::array<Vec2f, 2> uv;  ///< At low, at high.
};

std::vector<Side> sorted_sides(const Mesh& mesh)
{
    const std::vector<std::uint32_t> welded = welded_vertices(mesh);
    std::vector<Side> sides;
    sides.reserve(mesh.triangles.size() * 3);
    for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
        for (std::size_t i = 0; i < 3; ++i)
        {
            const std::size_t j = (i + 1) % 3;
            Side side{welded[mesh.triangles[face][i]],
                      welded[mesh.triangles[face][j]],
                      face,
                      {mesh.texcoords[3 * std::size_t{face} + i], mesh.texcoords[3 * std::size_t{face} + j]}};
            if (side.low > side.high)
            {
                std::swap(side.low, side.high);
                std::swap(side.uv[0], side.uv[1]);
            }
            if (side.low != side.high)
                sides.push_back(side);
        }
    std::sort(sides.begin(), sides.end(),
              [](const Side& a, const Side& b) { return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face); });
    return sides;
}

}  // namespace

Mesh welded(const Mesh& mesh)
{
    return joined(mesh, welded_vertices(mesh));
}

std::vector<Vec3f> smooth_normals(const Mesh& mesh)
{
    const auto first = welded_vertices(mesh);
    std::vector<Vec3f> normals = vertex_normals(joined(mesh, first));
    for (std::size_t v = 0; v < normals.size(); ++v)
        normals[v] = normals[first[v]];
    return normals;
}

Charts find_charts(const Mesh& mesh)
{
    const std::vector<Side> sides = sorted_sides(mesh);
    Charts charts;
    numerics::DisjointSets sets(mesh.triangles.size());
    for (std::size_t i = 1; i < sides.size(); ++i)
    {
        const Side& a = sides[i - 1];
        const Side& b = sides[i];
        if (a.low != b.low || a.high != b.high)
            continue;
        if (a.uv == b.uv)
            sets.join(a.face, b.face);
        else
            charts.seams.push_back({a.face, b.face, a.uv, b.uv});
    }
    charts.of_face = sets.numbers();
    charts.count = static_cast<std::uint32_t>(sets.count());
    return charts;
}

namespace
{
using Corners = std::array<Vec2d, 3>;

/// A face's corners in texels, x to the right and y down.
Corners texel_corners(const Mesh& mesh, std::uint32_t face, int size)
{
    Corners corners;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const Vec2f uv = mesh.texcoords[3 * std::size_t{face} + i];
        corners[i] = {double{uv.x} * size, (1 - double{uv.y}) * size};
    }
    return corners;
}

/// Tests squares of side 1 against one triangle.
class TriangleTest
{
  public:
    explicit TriangleTest(Corners corners) : corners_(corners)
    {
        if (cross(corners_[1] - corners_[0], corners_[2] - corners_[0]) < 0)
            std::swap(corners_[1], corners_[2]);
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec2d side = corners_[(i + 1) % 3] - corners_[i];
            rises_[i] = side.y;
            slopes_[i] = side.x / side.y;
            reaches_[i] = 0.5 * (std::abs(slopes_[i]) + 1);
        }
    }

    bool holds(Vec2d center) const { return inside_by(center, 0); }
    /// Rounding does not matter, so that faces side by side never hold the same center.
    bool surely_holds(Vec2d center) const { return inside_by(center, -0.01); }

    /// The texels of a row that can touch the triangle, and those of them whose centers it holds for sure: the others are still
    /// to be tested.
    struct Span
    {
        double first, last;            ///< Texels, with a margin for rounding.
        double first_held, last_held;  ///< Empty where first_held > last_held.
    };
    Span span(double center_y) const
    {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        constexpr double margin = 1e-3;
        constexpr double steep = 1e-5;  // For shorter sides, rounding could exceed the margin.
        Span result{-infinity, infinity, -infinity, infinity};
        for (std::size_t i = 0; i < 3; ++i)
        {
            if (std::abs(rises_[i]) < steep)
            {
                result.last_held = -infinity;
                continue;
            }
            // The x at which the test of a center at (x + 0.5, center_y) changes sign.
            const double held = corners_[i].x + slopes_[i] * (center_y - corners_[i].y) - 0.5;
            if (rises_[i] > 0)
            {
                result.last = std::min(result.last, held + reaches_[i] + margin);
                result.last_held = std::min(result.last_held, held - margin);
            }
            else
            {
                result.first = std::max(result.first, held - reaches_[i] - margin);
                result.first_held = std::max(result.first_held, held + margin);
            }
        }
        return result;
    }

    /// The square around `center` and the triangle share a point. Separating axes are the square's (the caller's bounding box)
    /// and the triangle's sides.
    bool touches(Vec2d center) const { return inside_by(center, 0.5); }

  private:
    bool inside_by(Vec2d p, double half_side) const
    {
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec2d side = corners_[(i + 1) % 3] - corners_[i];
            if (cross(side, p - corners_[i]) + half_side * (std::abs(side.x) + std::abs(side.y)) < 0)
                return false;
        }
        return true;
    }

    Corners corners_;
    std::array<double, 3> rises_;    ///< Rises of the sides, down the rows.
    std::array<double, 3> slopes_;   ///< How far right a side runs per row.
    std::array<double, 3> reaches_;  ///< How far from a side a center can be whose square touches it, along its row.
};

struct Box
{
    int x0, x1, y0, y1;  ///< Inclusive.
};

Box bounding_box(const Corners& c, int size)
{
    const auto texel = [size](double at) { return static_cast<int>(std::clamp(std::floor(at), 0.0, size - 1.0)); };
    const auto [x0, x1] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [y0, y1] = std::minmax({c[0].y, c[1].y, c[2].y});
    return {texel(x0), texel(x1), texel(y0), texel(y1)};
}

/// Calls visit(texel, center, held) for the texels in the box that can touch the triangle; `held`: it holds the center for sure.
template <class Visit>
void for_each_near(const TriangleTest& test, const Box& box, int size, const Visit& visit)
{
    for (int y = box.y0; y <= box.y1; ++y)
    {
        const TriangleTest::Span span = test.span(y + 0.5);
        const int first = static_cast<int>(std::ceil(std::clamp<double>(span.first, box.x0, box.x1 + 1)));
        const int last = static_cast<int>(std::floor(std::clamp<double>(span.last, box.x0 - 1, box.x1)));
        for (int x = first; x <= last; ++x)
            visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x),
                  Vec2d{x + 0.5, y + 0.5}, x >= span.first_held && x <= span.last_held);
    }
}

/// Only in the rows `first_row` to `last_row`, some of which are the face's.
void draw_face(const Mesh& mesh, std::uint32_t face, int first_row, int last_row, TexelFaces& result)
{
    const Corners corners = texel_corners(mesh, face, result.size);
    Box box = bounding_box(corners, result.size);
    box.y0 = std::max(box.y0, first_row);
    box.y1 = std::min(box.y1, last_row);
    const TriangleTest test(corners);
    for_each_near(test, box, result.size,
                  [&](std::size_t texel, Vec2d center, bool held)
                  {
                      if (result.inside[texel])
                          return;
                      if (held || test.holds(center))
                      {
                          result.face[texel] = face;
                          result.inside[texel] = 1;
                      }
                      else if (!result.covered(texel) && test.touches(center))
                          result.face[texel] = face;
                  });
}

/// The point on the face's plane at a place in the texture.
Vec3d point_at(const FaceFrame& face, Vec2d place)
{
    const Vec2d to = place - face.corners[0];
    const double b = cross(to, face.corners[2] - face.corners[0]) / face.area;
    const double c = cross(face.corners[1] - face.corners[0], to) / face.area;
    return face.points[0] + (face.points[1] - face.points[0]) * b + (face.points[2] - face.points[0]) * c;
}

double m2_of(const FaceFrame& face)
{
    return length(face.normal()) / 2;
}

/// The shares of a surface that are not where painting expects them.
struct LayoutFaults
{
    double overlapping = 0;
    double without_texels = 0;
};

LayoutFaults layout_faults(const Mesh& mesh, const Progress& progress)
{
    constexpr double same_place_texels = 4;
    constexpr double no_texels = 1e-6;  // Share of its fair area below which a face has no room.
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    double m2 = 0;
    double squares = 0;  // Sum of the faces' areas in the unit square.
    for (std::uint32_t face = 0; face < count; ++face)
    {
        const FaceFrame frame(mesh, face, 1);
        m2 += m2_of(frame);
        squares += std::abs(frame.area) / 2;
    }
    // A smaller raster suffices where thousands of faces overlap.
    const int size = static_cast<int>(std::clamp(4096 / std::sqrt(squares + 1e-9), 16.0, 2048.0));
    const double same_place_m = same_place_texels * mean_texel_m(mesh, size);
    const std::size_t texels = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    std::vector<std::uint32_t> first(texels, TexelFaces::none);
    std::vector<std::uint8_t> is_shared(texels, 0);
    LayoutFaults faults;
    for (std::uint32_t face = 0; face < count; ++face)
    {
        if (face % 1024 == 0)
            progress.check_canceled();
        const FaceFrame frame(mesh, face, size);
        const double area = std::abs(frame.area) / 2;
        if (area * m2 <= no_texels * m2_of(frame) * squares * static_cast<double>(texels))
        {
            faults.without_texels += m2_of(frame) / m2;
            continue;
        }
        const TriangleTest test(frame.corners);
        for_each_near(test, bounding_box(frame.corners, size), size,
                      [&](std::size_t texel, Vec2d center, bool)
                      {
                          if (!test.surely_holds(center))
                              return;
                          if (first[texel] == TexelFaces::none)
                          {
                              first[texel] = face;
                              return;
                          }
                          const FaceFrame other(mesh, first[texel], size);
                          if (frame.area * other.area < 0 ||
                              length(point_at(frame, center) - point_at(other, center)) <= same_place_m)
                              return;
                          faults.overlapping += m2_of(frame) / area / m2;
                          if (std::exchange(is_shared[texel], std::uint8_t{1}) == 0)
                              faults.overlapping += 2 * m2_of(other) / std::abs(other.area) / m2;
                      });
    }
    return faults;
}

/// A chart too small to hold any texel center owns the texels it touches.
void adopt_small_charts(const Charts& charts, TexelFaces& result)
{
    std::vector<std::uint8_t> has_center(charts.count, 0);
    for (std::size_t texel = 0; texel < result.face.size(); ++texel)
        if (result.inside[texel])
            has_center[charts.of_face[result.face[texel]]] = 1;
    if (std::ranges::find(has_center, 0) == has_center.end())
        return;
    for (std::size_t texel = 0; texel < result.face.size(); ++texel)
        if (result.covered(texel) && !has_center[charts.of_face[result.face[texel]]])
            result.inside[texel] = 1;
}
}  // namespace

void check_has_atlas(const Mesh& mesh, std::string_view source, std::string_view wire)
{
    check_mesh(mesh, source);
    if (mesh.texcoords.empty())
        throw Error(fmt::format("{} has no texcoords: wire {}", source, wire));
}

void check_layout(const Mesh& mesh, std::string_view source, RunContext& run)
{
    constexpr double most = 0.05;
    constexpr double hardly_any = 0.001;
    const LayoutFaults faults = layout_faults(mesh, run);
    const auto tell = [&](double share, const char* what)
    {
        if (share <= hardly_any)
            return;
        const std::string text = fmt::format("{:.{}f} % of the surface of {} {}; the way on is a new atlas (atlas.project)",
                                             100 * std::min(share, 1.0), share < 0.01 ? 1 : 0, source, what);
        if (share > most)
            throw Error(text);
        run.warning(text);
    };
    tell(faults.overlapping, "lies on other parts in the atlas and would show their paint");
    tell(faults.without_texels, "has no room in the atlas, since the texcoords of a face are a point or a line");
}

std::size_t TexelFaces::at(Vec2f uv) const
{
    const auto texel = [this](double along)
    { return static_cast<std::size_t>(std::clamp(std::floor(along * size), 0.0, size - 1.0)); };
    return texel(1 - double{uv.y}) * static_cast<std::size_t>(size) + texel(double{uv.x});
}

TexelFaces find_texel_faces(const Mesh& mesh, const Charts& charts, int size, const Progress& progress)
{
    TexelFaces result;
    result.size = size;
    const std::size_t texels = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    result.face.assign(texels, TexelFaces::none);
    result.inside.assign(texels, 0);
    constexpr std::size_t rows_per_band = 32;
    std::vector<std::vector<std::uint32_t>> faces_in((static_cast<std::size_t>(size) + rows_per_band - 1) / rows_per_band);
    for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
    {
        if (face % 4096 == 0)
            progress.check_canceled();
        const Box box = bounding_box(texel_corners(mesh, face, size), size);
        const std::size_t last = static_cast<std::size_t>(box.y1) / rows_per_band;
        for (std::size_t band = static_cast<std::size_t>(box.y0) / rows_per_band; band <= last; ++band)
            faces_in[band].push_back(face);
    }
    parallel_for(faces_in.size(), 1, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t band = begin; band < end; ++band)
                         for (std::size_t i = 0; i < faces_in[band].size(); ++i)
                         {
                             if (i % 1024 == 0)
                                 progress.check_canceled();
                             draw_face(mesh, faces_in[band][i], static_cast<int>(band * rows_per_band),
                                       static_cast<int>((band + 1) * rows_per_band) - 1, result);
                         }
                 });
    adopt_small_charts(charts, result);
    return result;
}

std::array<double, 3> texel_weights(const Mesh& mesh, const TexelFaces& faces, std::size_t texel)
{
    const auto size = static_cast<std::size_t>(faces.size);
    const Vec2d center{static_cast<double>(texel % size) + 0.5, static_cast<double>(texel / size) + 0.5};
    return weights_at(texel_corners(mesh, faces.face[texel], faces.size), center);
}

Vec3f texel_position(const Mesh& mesh, const TexelFaces& faces, std::size_t texel)
{
    return point_in(mesh, faces.face[texel], texel_weights(mesh, faces, texel));
}

namespace
{
Vec2f between(const std::array<Vec2f, 2>& ends, float share)
{
    return ends[0] * (1 - share) + ends[1] * share;
}
}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> seam_links(const Charts& charts, const TexelFaces& faces)
{
    const auto chart_at = [&](std::size_t texel)
    { return faces.covered(texel) ? charts.of_face[faces.face[texel]] : TexelFaces::none; };

    std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
    for (const Seam& seam : charts.seams)
    {
        // Two steps per texel, so that no texel along the seam is stepped over.
        const float longer = std::max(length(seam.first[1] - seam.first[0]), length(seam.second[1] - seam.second[0]));
        const int steps = 1 + static_cast<int>(std::ceil(2 * longer * static_cast<float>(faces.size)));
        for (int i = 0; i < steps; ++i)
        {
            const float share = (static_cast<float>(i) + 0.5F) / static_cast<float>(steps);
            const std::size_t a = faces.at(between(seam.first, share));
            const std::size_t b = faces.at(between(seam.second, share));
            if (a == b || chart_at(a) != charts.of_face[seam.first_face] || chart_at(b) != charts.of_face[seam.second_face])
                continue;
            links.emplace_back(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
            links.emplace_back(static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(a));
        }
    }
    std::sort(links.begin(), links.end());
    links.erase(std::unique(links.begin(), links.end()), links.end());
    return links;
}

double mean_texel_m(const Mesh& mesh, int size_px)
{
    double area = 0;
    double uv_area = 0;
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const FaceFrame frame(mesh, f, 1);
        area += length(cross(frame.points[1] - frame.points[0], frame.points[2] - frame.points[0]));
        uv_area += std::abs(frame.area);
    }
    return area > 0 && uv_area > 0 ? std::sqrt(area / uv_area) / size_px : 0;
}

double longest_side_m(const Mesh& mesh)
{
    numerics::Bounds<float> box;
    for (const Vec3f& position : mesh.positions)
        box.add(position);
    const Vec3f sides = box.high - box.low;
    return double{std::max({sides.x, sides.y, sides.z})};
}

double usual_stroke_m(const Mesh& mesh, double texel_m)
{
    constexpr double room_m = 3;
    constexpr double in_room_m = 0.035;
    constexpr double least_texels = 2;
    return std::max(least_texels * texel_m, in_room_m * std::min(1.0, longest_side_m(mesh) / room_m));
}

}  // namespace fresco::texturing
