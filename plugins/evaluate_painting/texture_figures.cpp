#include "texture_figures.h"

#include <fresco/error.h>
#include <fresco/images/lab.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>
#include <fresco/random.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

constexpr int inside_count = 200'000;
constexpr double crease_cosine = 0.86602540378443865;  // 30 degrees
constexpr double near_texels = 2.5;  // A point one texel away lies in a texel whose center may be almost another one away.
constexpr double most_heights = 16;  // Beyond, a narrow face's slope of uv is mostly rounding.
constexpr double crease_texels = 4;
constexpr std::size_t faces_per_check = 4096;

/// A face in space and in the atlas.
struct Face
{
    std::array<Vec3d, 3> at;
    std::array<Vec2d, 3> uv;

    Face(const Mesh& mesh, std::uint32_t face)
    {
        for (std::size_t i = 0; i < 3; ++i)
        {
            at[i] = vec_cast<double>(mesh.positions[mesh.triangles[face][i]]);
            const Vec2f texcoord = mesh.texcoords[3 * std::size_t{face} + i];
            uv[i] = {double{texcoord.x}, double{texcoord.y}};
        }
    }
    double area() const { return length(cross(at[1] - at[0], at[2] - at[0])) / 2; }
    double uv_area() const { return std::abs(cross(uv[1] - uv[0], uv[2] - uv[0])) / 2; }
};

Vec2f to_float(Vec2d v)
{
    return {static_cast<float>(v.x), static_cast<float>(v.y)};
}

template <class V>
V between(V a, V b, double share)
{
    return a * (1 - share) + b * share;
}

/// One side of a seam: its ends in space and in the atlas, and how uv changes per meter away from it.
struct SeamSide
{
    std::array<Vec3d, 2> at;
    std::array<Vec2d, 2> uv;
    Vec2d uv_per_m;
    double height_m = 0;
};

/// Nothing for a face without height above the seam, or that is not the seam's.
std::optional<SeamSide> seam_side(const Mesh& mesh, std::uint32_t face_index, const std::array<Vec2f, 2>& ends)
{
    const Face face(mesh, face_index);
    for (std::size_t i = 0; i < 3; ++i)
        for (const auto& [j, k] : {std::pair{(i + 1) % 3, (i + 2) % 3}, std::pair{(i + 2) % 3, (i + 1) % 3}})
        {
            if (to_float(face.uv[i]) != ends[0] || to_float(face.uv[j]) != ends[1])
                continue;
            const Vec3d along = face.at[j] - face.at[i];
            const double length_squared = dot(along, along);
            if (length_squared <= 0)
                continue;
            const double foot = dot(face.at[k] - face.at[i], along) / length_squared;
            const double height = length(face.at[k] - between(face.at[i], face.at[j], foot));
            if (height <= 0)
                continue;
            return SeamSide{{face.at[i], face.at[j]},
                            {face.uv[i], face.uv[j]},
                            (face.uv[k] - between(face.uv[i], face.uv[j], foot)) * (1 / height),
                            height};
        }
    return std::nullopt;
}

class PairFinder
{
  public:
    PairFinder(const Mesh& mesh, int size_px, const Progress& progress)
        : mesh_(mesh), progress_(progress), charts_(find_charts(mesh)), normals_(face_normals(mesh)),
          texels_(find_texel_faces(mesh, charts_, size_px, progress))
    {
        double uv_area = 0;
        for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
        {
            area_ += Face(mesh, face).area();
            uv_area += Face(mesh, face).uv_area();
        }
        if (!(area_ > 0) || !(uv_area > 0))
            throw Error(std::string("the mesh on port 'textured_mesh' has no area ") + (area_ > 0 ? "in its atlas" : "in space") +
                        ": its seams cannot be measured");
        step_m_ = std::sqrt(area_ / uv_area) / size_px;
    }

    double step_m() const { return step_m_; }

    std::vector<TexcoordPair> across() const
    {
        std::vector<TexcoordPair> pairs;
        double next = step_m_ / 2;  // Along the seam that begins, from its first end.
        for (std::size_t i = 0; i < charts_.seams.size(); ++i)
        {
            if (i % faces_per_check == 0)
                progress_.check_canceled();
            const Seam& seam = charts_.seams[i];
            const auto first = seam_side(mesh_, seam.first_face, seam.first);
            const auto second = seam_side(mesh_, seam.second_face, seam.second);
            if (!first || !second)
                continue;
            const double seam_m = length(first->at[1] - first->at[0]);
            while (next < seam_m)
            {
                add_across(seam, *first, *second, next / seam_m, pairs);
                next += step_m_;
            }
            next -= seam_m;
        }
        return pairs;
    }

    std::vector<TexcoordPair> inside() const
    {
        std::vector<TexcoordPair> pairs;
        Random random(1);
        const double spacing = area_ / inside_count;
        double next = spacing / 2;  // Area to pass until the next pair.
        for (std::uint32_t index = 0; index < mesh_.triangles.size(); ++index)
        {
            if (index % faces_per_check == 0)
                progress_.check_canceled();
            const Face face(mesh_, index);
            while (next < face.area())
            {
                add_inside(index, face, random, pairs);
                next += spacing;
            }
            next -= face.area();
        }
        return pairs;
    }

  private:
    /// One way from the middle of a pair over its chart.
    struct Way
    {
        std::uint32_t chart = 0;
        Vec2d from;
        Vec2d uv_per_m;
    };

    /// The face so many texels along the way, where it belongs to the chart and is near the middle.
    std::optional<std::uint32_t> face_at(const Way& way, double texels, Vec3d middle) const
    {
        const Vec2d uv = place(way, texels);
        if (!(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1))
            return std::nullopt;
        const std::size_t texel = texels_.at(to_float(uv));
        if (!texels_.covered(texel) || charts_.of_face[texels_.face[texel]] != way.chart)
            return std::nullopt;
        if (length(vec_cast<double>(texel_position(mesh_, texels_, texel)) - middle) > (texels + near_texels) * step_m_)
            return std::nullopt;
        return texels_.face[texel];
    }

    Vec2d place(const Way& way, double texels) const { return way.from + way.uv_per_m * (texels * step_m_); }

    bool is_crease(std::optional<std::uint32_t> a, std::optional<std::uint32_t> b) const
    {
        return a && b && dot(vec_cast<double>(normals_[*a]), vec_cast<double>(normals_[*b])) <= crease_cosine;
    }

    void add(const Way& first, const Way& second, Vec3d middle, std::vector<TexcoordPair>& pairs) const
    {
        const auto face_1 = face_at(first, 1, middle);
        const auto face_2 = face_at(second, 1, middle);
        if (!face_1 || !face_2 || is_crease(face_1, face_2))
            return;
        // A corner may be rounded: faces farther away tell.
        const auto far_1 = face_at(first, crease_texels, middle);
        const auto far_2 = face_at(second, crease_texels, middle);
        if (is_crease(far_1, far_2) || is_crease(face_1, far_2) || is_crease(far_1, face_2))
            return;
        pairs.push_back({to_float(place(first, 1)), to_float(place(second, 1))});
    }

    void add_across(const Seam& seam, const SeamSide& first, const SeamSide& second, double share,
                    std::vector<TexcoordPair>& pairs) const
    {
        if (std::min(first.height_m, second.height_m) * most_heights < step_m_)
            return;
        add({charts_.of_face[seam.first_face], between(first.uv[0], first.uv[1], share), first.uv_per_m},
            {charts_.of_face[seam.second_face], between(second.uv[0], second.uv[1], share), second.uv_per_m},
            between(first.at[0], first.at[1], share), pairs);
    }

    void add_inside(std::uint32_t index, const Face& face, Random& random, std::vector<TexcoordPair>& pairs) const
    {
        // Drawn for every pair, so that one that is left out does not change the others.
        double s = random.uniform();
        double t = random.uniform();
        const double angle = 2 * std::numbers::pi * random.uniform();
        if (s + t > 1)
        {
            s = 1 - s;
            t = 1 - t;
        }
        const Vec3d side_1 = face.at[1] - face.at[0];
        const Vec3d side_2 = face.at[2] - face.at[0];
        const Vec3d along = normalized(side_1);
        const double width = length(side_1);
        const double height = length(side_2 - along * dot(side_2, along));
        if (height * most_heights < step_m_ || width * most_heights < step_m_)
            return;
        // A meter along side 1 and upright to it, as shares of both sides.
        const double share_2 = std::sin(angle) / height;
        const double share_1 = (std::cos(angle) - share_2 * dot(side_2, along)) / width;
        const Vec2d uv_side_1 = face.uv[1] - face.uv[0];
        const Vec2d uv_side_2 = face.uv[2] - face.uv[0];
        const Vec2d middle = face.uv[0] + uv_side_1 * s + uv_side_2 * t;
        const Vec2d uv_per_m = uv_side_1 * share_1 + uv_side_2 * share_2;
        const std::uint32_t chart = charts_.of_face[index];
        add({chart, middle, uv_per_m * -1}, {chart, middle, uv_per_m}, face.at[0] + side_1 * s + side_2 * t, pairs);
    }

    const Mesh& mesh_;
    const Progress& progress_;
    Charts charts_;
    std::vector<Vec3f> normals_;
    TexelFaces texels_;
    double area_ = 0;
    double step_m_ = 0;  ///< Side of a texel.
};

}  // namespace

SeamPairs find_seam_pairs(const Mesh& mesh, int size_px, const Progress& progress)
{
    const PairFinder finder(mesh, size_px, progress);
    return {2 * finder.step_m(), finder.across(), finder.inside()};
}

namespace
{

constexpr std::size_t pairs_per_piece = 8192;

/// The four texels of a bilinear lookup, clamped at the borders.
struct Footprint
{
    numerics::Between<float> x, y;

    Footprint(Vec2f uv, int size)
        : x(numerics::between<float>(double{uv.x} * size - 0.5, size)),
          y(numerics::between<float>(double{1 - uv.y} * size - 0.5, size))
    {
    }

    template <class T>
    float value(const Raster<T>& raster, int channel) const
    {
        return numerics::bilinear(x, y, [&](int u, int v) { return static_cast<float>(raster.at(u, v, channel)); });
    }
};

/// The sum of differences over pairs that have one, and their number.
struct Sum
{
    double differences = 0;
    std::size_t count = 0;
};

/// `color_at`: a place's L*a*b*, nothing where it is not known.
template <class ColorAt>
Sum sum_of(std::span<const TexcoordPair> pairs, const ColorAt& color_at, const Progress& progress)
{
    std::vector<Sum> pieces((pairs.size() + pairs_per_piece - 1) / pairs_per_piece);
    parallel_for(pairs.size(), pairs_per_piece, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     Sum& sum = pieces[begin / pairs_per_piece];
                     for (const TexcoordPair& pair : pairs.subspan(begin, end - begin))
                     {
                         const std::optional<Vec3f> a = color_at(pair.first);
                         const std::optional<Vec3f> b = color_at(pair.second);
                         if (!a || !b)
                             continue;
                         sum.differences += double{length(*a - *b)};
                         ++sum.count;
                     }
                 });
    Sum all;
    for (const Sum& piece : pieces)
    {
        all.differences += piece.differences;
        all.count += piece.count;
    }
    return all;
}

template <class ColorAt>
SeamFigures figures_of(const SeamPairs& pairs, const ColorAt& color_at, const Progress& progress)
{
    const Sum across = sum_of(std::span(pairs.across), color_at, progress);
    const Sum inside = sum_of(std::span(pairs.inside), color_at, progress);
    const auto mean = [](const Sum& sum)
    { return sum.count > 0 ? sum.differences / static_cast<double>(sum.count) : std::numeric_limits<double>::quiet_NaN(); };
    return {mean(across), mean(inside), across.count, inside.count};
}

}  // namespace

double SeamFigures::ratio() const
{
    return inside > 0 ? across / inside : std::numeric_limits<double>::quiet_NaN();
}

SeamFigures seam_figures(const SeamPairs& pairs, const Raster8& picture, const Progress& progress)
{
    const auto color_at = [&](Vec2f uv) -> std::optional<Vec3f>
    {
        const Footprint at(uv, picture.width);
        return lab_from_rgb(Vec3f{at.value(picture, 0), at.value(picture, 1), at.value(picture, 2)} * (1 / 255.0F));
    };
    return figures_of(pairs, color_at, progress);
}

SeamFigures seam_figures(const SeamPairs& pairs, const Texture& texture, const Progress& progress)
{
    texturing::check_texture(texture);
    const RasterF picture = texturing::collapse(texture, progress);
    const auto color_at = [&](Vec2f uv) -> std::optional<Vec3f>
    {
        const Footprint at(uv, picture.width);
        for (const int y : {at.y.first, at.y.second})
            for (const int x : {at.x.first, at.x.second})
                if (texture.seen.at(x, y) == 0)
                    return std::nullopt;
        return lab_from_rgb({at.value(picture, 0), at.value(picture, 1), at.value(picture, 2)});
    };
    return figures_of(pairs, color_at, progress);
}

namespace
{

constexpr int most_cells = 8192;
constexpr int bins_per_window = 32;
constexpr double window_area = 0.01;

/// The picture cut into squares, the last of a row or column perhaps cut short.
class Squares
{
  public:
    Squares(const SourceMap& source, double side_x, double side_y)
        : side_x_(side_x), side_y_(side_y), columns_(count(source.picture_width, side_x)),
          rows_(count(source.picture_height, side_y)), texels_(columns_ * rows_)
    {
    }

    void add(Vec2f at) { ++texels_[square(double{at.y}, side_y_, rows_) * columns_ + square(double{at.x}, side_x_, columns_)]; }

    double used_share() const
    {
        const auto used = std::ranges::count_if(texels_, [](std::uint32_t count) { return count > 0; });
        return static_cast<double>(used) / static_cast<double>(texels_.size());
    }

    /// The most texels in any window of `side` x `side` squares within the picture.
    std::uint64_t fullest_window(std::size_t side) const
    {
        const std::size_t width = std::min(side, columns_);
        const std::size_t height = std::min(side, rows_);
        const std::vector<std::uint64_t> sums = sums_above_left();
        const auto sum = [&](std::size_t x, std::size_t y) { return sums[y * (columns_ + 1) + x]; };
        std::uint64_t most = 0;
        for (std::size_t y = 0; y + height <= rows_; ++y)
            for (std::size_t x = 0; x + width <= columns_; ++x)
                most = std::max(most, sum(x + width, y + height) - sum(x, y + height) - sum(x + width, y) + sum(x, y));
        return most;
    }

  private:
    static std::size_t count(int length, double side)
    {
        // A whole number of squares must not get another one by rounding.
        return static_cast<std::size_t>(std::max(1.0, std::ceil(length / side - 1e-6)));
    }
    static std::size_t square(double at, double side, std::size_t count)
    {
        return std::min(static_cast<std::size_t>(std::max(0.0, at / side)), count - 1);
    }
    std::vector<std::uint64_t> sums_above_left() const
    {
        std::vector<std::uint64_t> sums((columns_ + 1) * (rows_ + 1));
        for (std::size_t y = 0; y < rows_; ++y)
        {
            std::uint64_t row = 0;
            for (std::size_t x = 0; x < columns_; ++x)
            {
                row += texels_[y * columns_ + x];
                sums[(y + 1) * (columns_ + 1) + x + 1] = sums[y * (columns_ + 1) + x + 1] + row;
            }
        }
        return sums;
    }

    double side_x_;
    double side_y_;
    std::size_t columns_;
    std::size_t rows_;
    std::vector<std::uint32_t> texels_;
};

}  // namespace

SourceUse source_use(const SourceMap& source)
{
    const double width = source.picture_width;
    const double height = source.picture_height;
    const double cell = source.pixels_per_texel;
    const double bin = std::sqrt(window_area * width * height) / bins_per_window;
    Squares cells(source, std::max(cell, width / most_cells), std::max(cell, height / most_cells));
    Squares bins(source, bin, bin);
    SourceUse use;
    for (int y = 0; y < source.size_px(); ++y)
        for (int x = 0; x < source.size_px(); ++x)
            if (const auto place = source.place(x, y))
            {
                cells.add(place->at);
                bins.add(place->at);
                ++use.texels;
            }
    if (use.texels == 0)
        throw Error("the map on port 'source' has no texel from the picture: wire the map that belongs to the painted texture");
    use.picture_used = cells.used_share();
    use.largest_share = static_cast<double>(bins.fullest_window(bins_per_window)) / static_cast<double>(use.texels);
    return use;
}
