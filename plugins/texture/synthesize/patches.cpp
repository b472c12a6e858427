#include "patches.h"

#include <fresco/error.h>
#include <fresco/geometry/flatten.h>
#include <fresco/parallel.h>
#include <fresco/texturing/face_frame.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <malloc.h>
#include <numeric>

namespace fresco::synthesize
{

void give_back_memory()
{
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

namespace
{

constexpr std::size_t faces_per_piece = 2048;
constexpr std::size_t pieces_drawn_together = 64;

bool inside(const std::array<Vec2d, 3>& c, double area, Vec2d p)
{
    const double sign = area < 0 ? -1 : 1;
    for (std::size_t i = 0; i < 3; ++i)
        if (sign * cross(c[(i + 1) % 3] - c[i], p - c[i]) < 0)
            return false;
    return true;
}

}  // namespace

SurfaceGrid::SurfaceGrid(const PaintedSurface& surface, double spacing_m, const Progress& progress,
                         std::span<const std::uint8_t> wanted)
    : spacing_m_(spacing_m)
{
    lay_out(surface);
    const std::size_t faces = surface.mesh.triangles.size();
    // A cell on the border of two faces belongs to the first one: pieces of faces are drawn together, and added in order.
    std::vector<std::vector<Texel>> drawn(pieces_drawn_together);
    for (std::size_t first = 0; first < faces; first += pieces_drawn_together * faces_per_piece)
    {
        const std::size_t end = std::min(faces, first + pieces_drawn_together * faces_per_piece);
        parallel_for(end - first, faces_per_piece, progress,
                     [&](std::size_t from, std::size_t to)
                     {
                         progress.check_canceled();
                         std::vector<Texel>& out = drawn[from / faces_per_piece];
                         out.clear();
                         for (std::size_t face = first + from; face < first + to; ++face)
                             if (wanted.empty() || wanted[face] != 0)
                                 draw_face(surface, static_cast<std::uint32_t>(face), out);
                     });
        for (std::size_t piece = 0; piece * faces_per_piece < end - first; ++piece)
            for (const Texel& texel : drawn[piece])
                if (std::uint32_t& at = texel_of_cell_[texel.cell]; at == none)
                {
                    at = static_cast<std::uint32_t>(texels_.size());
                    texels_.push_back(texel);
                }
    }

    std::vector<std::uint32_t> largest(sheets_.size(), none);
    std::vector<double> area(sheets_.size(), 0.0);
    std::vector<std::uint8_t> has_texel(sheets_.size(), 0);
    for (const Texel& texel : texels_)
        has_texel[surface.charts.of_face[texel.face]] = 1;
    for (std::uint32_t face = 0; face < faces; ++face)
    {
        const std::uint32_t chart = surface.charts.of_face[face];
        const double a = length(geometry::area_vector(surface.mesh, face));
        if (a > area[chart])
        {
            area[chart] = a;
            largest[chart] = face;
        }
    }
    for (std::uint32_t chart = 0; chart < sheets_.size(); ++chart)
        if (has_sheet(chart) && !has_texel[chart])
            adopt(surface, chart, largest[chart]);
    sort_by_cells(faces);
    parallel_items(sheets_.size(), 1, progress,
                   [&](std::size_t chart)
                   {
                       if (has_sheet(static_cast<std::uint32_t>(chart)))
                           extend(sheets_[chart]);
                   });
}

void SurfaceGrid::sort_by_cells(std::size_t faces)
{
    std::vector<Texel> sorted;
    sorted.reserve(texels_.size());
    first_of_face_.assign(faces + 1, 0);
    for (std::uint32_t& texel : texel_of_cell_)
        if (texel != none)
        {
            sorted.push_back(texels_[texel]);
            texel = static_cast<std::uint32_t>(sorted.size() - 1);
            ++first_of_face_[sorted.back().face + 1];
        }
    texels_ = std::move(sorted);
    std::partial_sum(first_of_face_.begin(), first_of_face_.end(), first_of_face_.begin());
    of_face_.resize(texels_.size());
    std::vector<std::uint32_t> next(first_of_face_.begin(), first_of_face_.end() - 1);
    for (std::uint32_t texel = 0; texel < texels_.size(); ++texel)
        of_face_[next[texels_[texel].face]++] = texel;
}

void SurfaceGrid::lay_out(const PaintedSurface& surface)
{
    const std::uint32_t charts = surface.charts.count;
    std::vector<geometry::FlatBox> boxes(charts);
    for (std::size_t corner = 0; corner < surface.mesh.texcoords.size(); ++corner)
    {
        const Vec2f uv = surface.mesh.texcoords[corner];
        boxes[surface.charts.of_face[corner / 3]].add({double{uv.x}, double{uv.y}});
    }
    sheets_.resize(charts);
    std::size_t cells = 0;
    for (std::uint32_t c = 0; c < charts; ++c)
    {
        if (!(surface.uv_per_m[c] > 0))
            continue;
        Sheet& sheet = sheets_[c];
        sheet.uv_low = boxes[c].low;
        sheet.cells_per_uv = 1 / (surface.uv_per_m[c] * spacing_m_);
        const double width = std::ceil(boxes[c].size().x * sheet.cells_per_uv) + 2;
        const double height = std::ceil(boxes[c].size().y * sheet.cells_per_uv) + 2;
        if (static_cast<double>(cells) + width * height >= 4e9)
            throw Error(
                fmt::format("the surface has more than four billion texels of {:.3g} mm: use a larger stroke_cm, or check "
                            "that the mesh is in meters",
                            spacing_m_ * 1000));
        if (width > 65535)
            throw Error(
                fmt::format("a chart of the surface is {:.3g} m wide, more than 65535 texels of {:.3g} mm: check that the mesh "
                            "is in meters, or use a larger stroke_cm",
                            width * spacing_m_, spacing_m_ * 1000));
        sheet.width = static_cast<int>(width);
        sheet.height = static_cast<int>(height);
        sheet.first_cell = cells;
        cells += static_cast<std::size_t>(sheet.width) * static_cast<std::size_t>(sheet.height);
    }
    texel_of_cell_.assign(cells, none);
}

void SurfaceGrid::draw_face(const PaintedSurface& surface, std::uint32_t face, std::vector<Texel>& out) const
{
    const std::uint32_t chart = surface.charts.of_face[face];
    if (!has_sheet(chart))
        return;
    const Sheet& sheet = sheets_[chart];
    std::array<Vec2d, 3> c;
    for (std::size_t i = 0; i < 3; ++i)
        c[i] = place(chart, surface.mesh.texcoords[3 * std::size_t{face} + i]);
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    if (area == 0)
        return;
    const auto [x0, x1] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [y0, y1] = std::minmax({c[0].y, c[1].y, c[2].y});
    for (int y = sheet.row(y0); y <= sheet.row(y1); ++y)
        for (int x = sheet.column(x0); x <= sheet.column(x1); ++x)
            if (const Vec2d center{x + 0.5, y + 0.5}; inside(c, area, center))
                out.push_back({texturing::point_in(surface.mesh, face, texturing::weights_at(c, center)), face,
                               static_cast<std::uint32_t>(sheet.cell(x, y))});
}

void SurfaceGrid::adopt(const PaintedSurface& surface, std::uint32_t chart, std::uint32_t largest_face)
{
    constexpr std::array<double, 3> middle{1.0 / 3, 1.0 / 3, 1.0 / 3};
    const Sheet& sheet = sheets_[chart];
    Vec2d at;
    for (std::size_t i = 0; i < 3; ++i)
        at = at + place(chart, surface.mesh.texcoords[3 * std::size_t{largest_face} + i]) * middle[i];
    const auto cell = static_cast<std::uint32_t>(sheet.cell(sheet.column(at.x), sheet.row(at.y)));
    texel_of_cell_[cell] = static_cast<std::uint32_t>(texels_.size());
    texels_.push_back({texturing::point_in(surface.mesh, largest_face, middle), largest_face, cell});
}

/// Cells outside of the chart take the texel of the nearest one inside, ring by ring.
void SurfaceGrid::extend(const Sheet& sheet)
{
    const auto width = static_cast<std::size_t>(sheet.width);
    std::vector<std::size_t> ring;
    std::vector<std::size_t> next;
    const std::size_t count = width * static_cast<std::size_t>(sheet.height);
    std::uint32_t* cells = texel_of_cell_.data() + sheet.first_cell;
    for (std::size_t i = 0; i < count; ++i)
        if (cells[i] != none)
            ring.push_back(i);
    const auto visit_neighbors = [&](std::size_t i, const auto& visit)
    {
        const std::size_t x = i % width;
        if (x > 0)
            visit(i - 1);
        if (x + 1 < width)
            visit(i + 1);
        if (i >= width)
            visit(i - width);
        if (i + width < count)
            visit(i + width);
    };
    while (!ring.empty())
    {
        next.clear();
        for (const std::size_t i : ring)
            visit_neighbors(i,
                            [&](std::size_t other)
                            {
                                if (cells[other] != none)
                                    return;
                                cells[other] = cells[i];
                                next.push_back(other);
                            });
        ring.swap(next);
    }
}

namespace
{

constexpr float reach_cosine = 0.64278761F;  // 50 degrees
constexpr std::size_t patches_per_piece = 512;
constexpr std::size_t patches_per_list = patches_per_piece * 16;

/// With its x axis along a line, in the direction that is nearer to its own.
TangentFrame turned_along(const TangentFrame& frame, Vec3f line)
{
    const Vec3f flat = line - frame.out * dot(line, frame.out);
    const float size = length(flat);
    if (size < 1e-6F)
        return frame;
    const Vec3f right = flat * ((dot(flat, frame.right) < 0 ? -1 : 1) / size);
    return {right, cross(right, frame.out), frame.out};
}

struct Bounds
{
    float x0, x1, y0, y1;
};

Bounds bounds(const std::array<Vec2f, 3>& c)
{
    const auto [x0, x1] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [y0, y1] = std::minmax({c[0].y, c[1].y, c[2].y});
    return {x0, x1, y0, y1};
}

}  // namespace

/// Finds the surface under patches, one after another, on one thread.
class Patches::Walker
{
  public:
    Walker(const PaintedSurface& surface, const SurfaceGrid& grid, int side)
        : surface_(surface), grid_(grid), side_(side), half_(static_cast<float>(side) / 2),
          scale_(static_cast<float>(1 / grid.spacing_m())), visited_(surface.mesh.triangles.size(), 0),
          found_(static_cast<std::size_t>(side) * static_cast<std::size_t>(side))
    {
        for (int y = 1 - side; y < side; ++y)
            for (int x = 1 - side; x < side; ++x)
                around_.push_back({x, y});
        std::ranges::stable_sort(around_, {}, [](const Step& step) { return step.x * step.x + step.y * step.y; });
    }

    /// Calls visit(texel, at) for each texel under the patch, `at` in texels from its center, and fills its `points`.
    template <class Visit>
    void walk(const Patch& patch, Point* points, const Visit& visit)
    {
        ++stamp_;
        std::fill(found_.begin(), found_.end(), std::uint8_t{0});
        const std::uint32_t start = grid_.texels()[patch.texel].face;
        queue_.assign(1, start);
        visited_[start] = stamp_;
        bool own = false;
        const auto visit_texel = [&](std::uint32_t texel, Vec2f at)
        {
            own = own || texel == patch.texel;
            visit(texel, at);
        };
        for (std::size_t next = 0; next < queue_.size(); ++next)
        {
            const std::uint32_t face = queue_[next];
            std::array<Vec2f, 3> corners;
            for (std::size_t i = 0; i < 3; ++i)
                corners[i] = project(patch, surface_.mesh.positions[surface_.mesh.triangles[face][i]]);
            visit_texels(patch, face, corners, visit_texel);
            visit_points(face, corners, bounds(corners), points);
            for (std::size_t edge = 0; edge < 3; ++edge)
            {
                const std::uint32_t other = surface_.neighbors[face][edge];
                if (other == geometry::none || visited_[other] == stamp_ || is_beside(corners[edge], corners[(edge + 1) % 3]) ||
                    dot(surface_.normals[other], patch.frame.out) < reach_cosine)
                    continue;
                visited_[other] = stamp_;
                queue_.push_back(other);
            }
        }
        // The chart holds no cell's center.
        if (!own)
            visit(patch.texel, Vec2f{});
        extend(patch, points);
    }

  private:
    /// Whether an edge lies beside the patch, all of it on one side.
    bool is_beside(Vec2f a, Vec2f b) const
    {
        return std::min(a.x, b.x) > half_ || std::max(a.x, b.x) < -half_ || std::min(a.y, b.y) > half_ ||
               std::max(a.y, b.y) < -half_;
    }

    /// A point's place among those of a patch.
    std::size_t number(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x);
    }

    Vec2f project(const Patch& patch, Vec3f point) const { return patch.place(point) * scale_; }

    template <class Visit>
    void visit_texels(const Patch& patch, std::uint32_t face, const std::array<Vec2f, 3>& corners, const Visit& visit)
    {
        const auto visit_if_under = [&](std::uint32_t texel)
        {
            const Vec2f p = project(patch, grid_.texels()[texel].position);
            if (std::abs(p.x) <= half_ && std::abs(p.y) <= half_)
                visit(texel, p);
        };
        if (const auto texels = grid_.texels_of(face); texels.size() <= 4 * found_.size())
        {
            std::ranges::for_each(texels, visit_if_under);
            return;
        }
        const std::uint32_t chart = surface_.charts.of_face[face];
        std::array<Vec2d, 3> c;
        for (std::size_t i = 0; i < 3; ++i)
            c[i] = grid_.place(chart, surface_.mesh.texcoords[3 * std::size_t{face} + i]);
        geometry::FlatBox box(c);
        clip(corners, c, box.low, box.high);
        const SurfaceGrid::Sheet& sheet = grid_.sheet(chart);
        for (int y = sheet.row(box.low.y); y <= sheet.row(box.high.y); ++y)
            for (int x = sheet.column(box.low.x); x <= sheet.column(box.high.x); ++x)
            {
                const std::size_t at = sheet.cell(x, y);
                const std::uint32_t texel = grid_.texel_at(at);
                if (grid_.texels()[texel].cell == at && grid_.texels()[texel].face == face)
                    visit_if_under(texel);
            }
    }

    /// Shrinks a box of cells to what can lie under the patch, where the face is larger than that.
    void clip(const std::array<Vec2f, 3>& corners, const std::array<Vec2d, 3>& cells, Vec2d& low, Vec2d& high) const
    {
        const double side = side_;
        if (high.x - low.x <= 2 * side && high.y - low.y <= 2 * side)
            return;
        const Vec2d a{double{corners[1].x} - corners[0].x, double{corners[1].y} - corners[0].y};
        const Vec2d b{double{corners[2].x} - corners[0].x, double{corners[2].y} - corners[0].y};
        const double area = cross(a, b);
        if (std::abs(area) < 1e-9)
            return;
        const Vec2d ca = cells[1] - cells[0];
        const Vec2d cb = cells[2] - cells[0];
        geometry::FlatBox reached;
        for (const double x : {-0.5, 0.5})
            for (const double y : {-0.5, 0.5})
            {
                const Vec2d p{x * side - corners[0].x, y * side - corners[0].y};
                const double wa = cross(p, b) / area;
                const double wb = cross(a, p) / area;
                reached.add(cells[0] + ca * wa + cb * wb);
            }
        low = {std::max(low.x, reached.low.x), std::max(low.y, reached.low.y)};
        high = {std::min(high.x, reached.high.x), std::min(high.y, reached.high.y)};
    }

    void visit_points(std::uint32_t face, const std::array<Vec2f, 3>& c, const Bounds& box, Point* points)
    {
        const std::uint32_t chart = surface_.charts.of_face[face];
        const float area = cross(c[1] - c[0], c[2] - c[0]);
        if (!grid_.has_sheet(chart) || std::abs(area) < 1e-9F)
            return;
        const float per_area = 1 / area;
        const float middle = static_cast<float>(side_ - 1) / 2;
        const auto first = [&](float low) { return std::max(0, static_cast<int>(std::ceil(low + middle - 1e-3F))); };
        const auto last = [&](float high) { return std::min(side_ - 1, static_cast<int>(std::floor(high + middle + 1e-3F))); };
        for (int j = first(box.y0); j <= last(box.y1); ++j)
            for (int i = first(box.x0); i <= last(box.x1); ++i)
            {
                const std::size_t at = number(i, j);
                if (found_[at] != 0)
                    continue;
                const Vec2f p{static_cast<float>(i) - middle, static_cast<float>(j) - middle};
                const float w0 = cross(c[1] - p, c[2] - p) * per_area;
                const float w1 = cross(c[2] - p, c[0] - p) * per_area;
                const float w2 = 1 - w0 - w1;
                constexpr float outside = -1e-4F;
                if (w0 < outside || w1 < outside || w2 < outside)
                    continue;
                found_[at] = 1;
                const Vec2f* uv = &surface_.mesh.texcoords[3 * std::size_t{face}];
                points[at] = point(chart, uv[0] * w0 + uv[1] * w1 + uv[2] * w2);
            }
    }

    Point point(std::uint32_t chart, Vec2f uv) const
    {
        const SurfaceGrid::Sheet& sheet = grid_.sheet(chart);
        const Vec2d at = grid_.place(chart, uv);
        const double x = std::clamp(at.x - 0.5, 0.0, sheet.width - 1.004);
        const double y = std::clamp(at.y - 0.5, 0.0, sheet.height - 1.004);
        const auto column = static_cast<std::size_t>(x);
        const auto row = static_cast<std::size_t>(y);
        return {static_cast<std::uint32_t>(sheet.first_cell + row * static_cast<std::size_t>(sheet.width) + column),
                static_cast<std::uint16_t>(sheet.width), static_cast<std::uint8_t>((x - static_cast<double>(column)) * 256),
                static_cast<std::uint8_t>((y - static_cast<double>(row)) * 256)};
    }

    /// Points off the surface become the nearest ones on it.
    void extend(const Patch& patch, Point* points)
    {
        if (std::ranges::count(found_, 0) == std::ssize(found_))
        {
            const SurfaceGrid::Texel& texel = grid_.texels()[patch.texel];
            const SurfaceGrid::Sheet& sheet = grid_.sheet(surface_.charts.of_face[texel.face]);
            std::fill(points, points + found_.size(), Point{texel.cell, static_cast<std::uint16_t>(sheet.width), 0, 0});
            return;
        }
        for (int j = 0; j < side_; ++j)
            for (int i = 0; i < side_; ++i)
            {
                const std::size_t at = number(i, j);
                if (found_[at] == 0)
                    points[at] = points[nearest_found(i, j)];
            }
    }

    /// \pre There is one.
    std::size_t nearest_found(int i, int j) const
    {
        const auto is_found = [&](const Step& step)
        {
            const int x = i + step.x;
            const int y = j + step.y;
            return x >= 0 && y >= 0 && x < side_ && y < side_ && found_[number(x, y)] != 0;
        };
        const Step nearest = *std::ranges::find_if(around_, is_found);
        return number(i + nearest.x, j + nearest.y);
    }

    struct Step
    {
        int x, y;
    };

    const PaintedSurface& surface_;
    const SurfaceGrid& grid_;
    int side_;
    float half_;
    float scale_;
    std::uint32_t stamp_ = 0;
    std::vector<std::uint32_t> visited_;  ///< Per face: the stamp of the last walk that came there.
    std::vector<std::uint8_t> found_;
    std::vector<Step> around_;  ///< To points around one, the nearest first.
    std::vector<std::uint32_t> queue_;
};

namespace
{

/// Cells in a direction from the center that one word can tell, and more than a patch reaches.
constexpr int reach_cells = 32;

constexpr std::uint32_t near_word(int right, int down, std::uint32_t across, std::uint32_t along)
{
    return static_cast<std::uint32_t>(down + reach_cells) << 22U | static_cast<std::uint32_t>(right + reach_cells) << 16U |
           across << 8U | along;
}

}  // namespace

void Patches::PackedPoints::add(std::span<const Point> points, std::uint32_t cell)
{
    const auto width = static_cast<std::int64_t>(points.front().width);
    const std::size_t first = words_.size();
    first_.push_back(first);
    words_.push_back(points.front().width);
    for (const Point& point : points)
    {
        const std::int64_t away = std::int64_t{point.cell} - cell;
        const std::int64_t down = (away + (away < 0 ? -width : width) / 2) / width;
        const std::int64_t right = away - down * width;
        if (point.width != width || std::max(std::abs(right), std::abs(down)) >= reach_cells)
        {
            words_.resize(first);
            words_.push_back(0);
            for (const Point& each : points)
                words_.insert(words_.end(),
                              {each.cell, std::uint32_t{each.width} << 16U | std::uint32_t{each.across} << 8U | each.along});
            return;
        }
        words_.push_back(near_word(static_cast<int>(right), static_cast<int>(down), point.across, point.along));
    }
}

template <class Visit>
void Patches::PackedPoints::visit(std::size_t patch, std::uint32_t cell, const Visit& visit) const
{
    const std::uint32_t* word = &words_[first_[patch]];
    const std::uint32_t* const end = words_.data() + (patch + 1 < first_.size() ? first_[patch + 1] : words_.size());
    const std::uint32_t width = *word++;
    const auto fraction = [](std::uint32_t bits) { return static_cast<std::uint8_t>(bits & 0xFFU); };
    if (width == 0)
        for (; word != end; word += 2)
            visit(Point{word[0], static_cast<std::uint16_t>(word[1] >> 16U), fraction(word[1] >> 8U), fraction(word[1])});
    else
    {
        const std::uint32_t corner = cell - reach_cells * width - reach_cells;
        for (; word != end; ++word)
            visit(Point{corner + (*word >> 22U) * width + (*word >> 16U & 63U), static_cast<std::uint16_t>(width),
                        fraction(*word >> 8U), fraction(*word)});
    }
}

Patches::Patches(const PaintedSurface& surface, const SurfaceGrid& grid, const Upright& upright, int side, int stride,
                 const Progress& progress, std::span<const Vec3f> lines, std::span<const float> share)
    : side_(side), per_m_(static_cast<float>(1 / grid.spacing_m()))
{
    const auto& texels = grid.texels();
    const auto patch_at = [&](std::uint32_t texel)
    {
        const std::uint32_t face = texels[texel].face;
        const TangentFrame frame = frame_at(surface.normals[face], upright);
        return Patch{texels[texel].position, lines.empty() ? frame : turned_along(frame, lines[face]), texel};
    };

    const auto is_wanted = [share](std::uint32_t texel) { return share.empty() || share[texel] > 0; };
    for (std::uint32_t texel = 0; texel < texels.size(); ++texel)
    {
        if (!is_wanted(texel))
            continue;
        const std::uint32_t chart = surface.charts.of_face[texels[texel].face];
        const SurfaceGrid::Sheet& sheet = grid.sheet(chart);
        const auto place = static_cast<int>(texels[texel].cell - sheet.first_cell);
        if (place % sheet.width % stride == 0 && place / sheet.width % stride == 0)
            patches_.push_back(patch_at(texel));
    }

    regular_ = patches_.size();
    std::vector<std::vector<std::uint32_t>> lists((regular_ + patches_per_list - 1) / patches_per_list + 1);
    points_.resize(lists.size());
    std::vector<std::uint32_t> counts(regular_);  // Texels under each patch, which its list holds one patch after another.
    std::vector<std::atomic<std::uint8_t>> near_center(texels.size());
    const auto reach = static_cast<float>(stride);
    const auto walk = [&](Walker& walker, std::vector<Point>& points, std::size_t i, std::size_t at_list)
    {
        if (i % patches_per_piece == 0)
            progress.check_canceled();
        std::vector<std::uint32_t>& list = lists[at_list];
        const std::size_t before = list.size();
        walker.walk(patches_[i], points.data(),
                    [&](std::uint32_t texel, Vec2f at)
                    {
                        list.push_back(texel);
                        if (std::abs(at.x) <= reach && std::abs(at.y) <= reach)
                            near_center[texel].store(1, std::memory_order_relaxed);
                    });
        counts[i] = static_cast<std::uint32_t>(list.size() - before);
        points_[at_list].add(points, texels[patches_[i].texel].cell);
    };
    parallel_for(regular_, patches_per_list, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     Walker walker(surface, grid, side);
                     std::vector<Point> points(points_per_patch());
                     const std::size_t at_list = begin / patches_per_list;
                     points_[at_list].reserve((end - begin) * (points_per_patch() + 1));
                     for (std::size_t i = begin; i < end; ++i)
                         walk(walker, points, i, at_list);
                     lists[at_list].shrink_to_fit();
                     points_[at_list].shrink();
                 });
    // One after another: each shows which texels are still bare.
    Walker alone(surface, grid, side);
    std::vector<Point> points(points_per_patch());
    for (std::uint32_t texel = 0; texel < texels.size(); ++texel)
        if (is_wanted(texel) && near_center[texel].load(std::memory_order_relaxed) == 0)
        {
            patches_.push_back(patch_at(texel));
            counts.push_back(0);
            walk(alone, points, patches_.size() - 1, lists.size() - 1);
        }

    patches_.shrink_to_fit();

    first_cover_.assign(texels.size() + 1, 0);
    for (const auto& list : lists)
        for (const std::uint32_t texel : list)
            ++first_cover_[texel + 1];
    std::partial_sum(first_cover_.begin(), first_cover_.end(), first_cover_.begin());
    covers_ = std::make_unique_for_overwrite<std::uint32_t[]>(first_cover_.back());
    std::vector<std::uint32_t> filled(texels.size(), 0);
    std::uint32_t patch = 0;
    for (auto& list : lists)
    {
        for (std::size_t at = 0; at < list.size(); ++patch)
            for (std::uint32_t n = 0; n < counts[patch]; ++n, ++at)
                covers_[first_cover_[list[at]] + filled[list[at]]++] = patch;
        list = std::vector<std::uint32_t>();
        give_back_memory();  // So that covers_, which nothing has touched yet, takes the place of the lists.
    }
}

template <class Visit>
void Patches::visit_points(const SurfaceGrid& grid, std::size_t patch, const Visit& visit) const
{
    const bool is_regular = patch < regular_;
    const PackedPoints& points = is_regular ? points_[patch / patches_per_list] : points_.back();
    points.visit(is_regular ? patch % patches_per_list : patch - regular_, grid.texels()[patches_[patch].texel].cell, visit);
}

void Patches::sample(const SurfaceGrid& grid, std::span<const Vec3f> values, std::size_t patch, Vec3f* out) const
{
    visit_points(grid, patch,
                 [&](const Point& point)
                 {
                     const float x = static_cast<float>(point.across) / 256;
                     const float y = static_cast<float>(point.along) / 256;
                     const std::size_t cell = point.cell;
                     const std::size_t below = cell + point.width;
                     const Vec3f top = values[grid.texel_at(cell)] * (1 - x) + values[grid.texel_at(cell + 1)] * x;
                     const Vec3f bottom = values[grid.texel_at(below)] * (1 - x) + values[grid.texel_at(below + 1)] * x;
                     *out++ = top * (1 - y) + bottom * y;
                 });
}

std::vector<std::uint8_t> Patches::sampled(const SurfaceGrid& grid, const Progress& progress) const
{
    std::vector<std::uint8_t> result(grid.texels().size(), 0);
    for (std::size_t patch = 0; patch < count(); ++patch)
    {
        if (patch % patches_per_piece == 0)
            progress.check_canceled();
        visit_points(grid, patch,
                     [&](const Point& point)
                     {
                         for (const std::size_t cell : {std::size_t{point.cell}, std::size_t{point.cell} + point.width})
                             result[grid.texel_at(cell)] = result[grid.texel_at(cell + 1)] = 1;
                     });
    }
    return result;
}

}  // namespace fresco::synthesize
