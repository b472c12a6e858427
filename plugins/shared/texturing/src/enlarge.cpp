#include <fresco/texturing/enlarge.h>

#include <fresco/error.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fmt/format.h>
#include <numbers>
#include <vector>

namespace fresco::enlarge
{
namespace
{

constexpr std::size_t window = 9;   // Texels of the map around a texel.
constexpr float same_copy = 0.75F;  // Texels of the map: copies that meet this closely continue each other.
constexpr float negligible = 0.004F;

/// A copy of the picture around a texel of the map, as a map from texels to pixels.
struct Copy
{
    Vec2f center;  ///< Pixel (0, 0) has its center at (0, 0).
    Vec2f right;   ///< Per texel of the map.
    Vec2f down;
    std::uint8_t size = 0;  ///< Index of the picture's size.
    Vec3f shift;            ///< Added to its colors, in 0 to 255.

    Vec2f at(Vec2f texels) const { return center + right * texels.x + down * texels.y; }
};

/// The copies that meet at a texel of the map, sorted into groups that continue each other.
struct Meeting
{
    std::array<Copy, window> copies;              ///< Copies around the middle texel's center.
    std::array<std::uint8_t, window> group{};     ///< Group of each copy.
    std::array<std::uint8_t, window> neighbor{};  ///< Place of each copy in the window, row by row.
    std::array<std::uint8_t, window> size{};      ///< Index of the picture's size for each group.
    std::size_t count = 0;
    std::size_t groups = 0;
};

/// The weights of a quadratic B-spline: of the texel before, this one and the next. Their sum is 1 and their mean `t`, so that
/// places that continue each other are interpolated exactly.
std::array<float, 3> spline_weights(float t)
{
    return {0.5F * (0.5F - t) * (0.5F - t), 0.75F - t * t, 0.5F * (0.5F + t) * (0.5F + t)};
}

/// Lanczos's window of three lobes, sharpened by what it takes on average from the finest detail: lookups at any place between
/// pixels keep the energy of the picture's finest band, of which a bilinear lookup loses half.
class Lanczos
{
  public:
    static constexpr std::size_t taps = 6;

    Lanczos()
    {
        for (std::size_t i = 0; i <= steps; ++i)
        {
            // Zero at both ends, for the neighbors of the outermost.
            std::array<double, taps + 2> plain{};
            for (std::size_t k = 0; k < taps; ++k)
                plain[k + 1] = lobe(static_cast<double>(k) - 2 - static_cast<double>(i) / steps);
            std::array<double, taps> sharp{};
            double sum = 0;
            for (std::size_t k = 0; k < taps; ++k)
                sum += sharp[k] = plain[k + 1] + sharpening * (2 * plain[k + 1] - plain[k] - plain[k + 2]);
            for (std::size_t k = 0; k < taps; ++k)
                weights_[i][k] = static_cast<float>(sharp[k] / sum);
        }
    }

    /// For the pixels from two before to three past the one that a place is `t` (0 to 1) past.
    const std::array<float, taps>& weights(float t) const { return weights_[static_cast<std::size_t>(t * steps + 0.5F)]; }

  private:
    static constexpr std::size_t steps = 256;
    static constexpr double sharpening = 0.02;

    static double lobe(double x)
    {
        const double a = std::numbers::pi * x;
        return std::abs(x) < 1e-9 ? 1 : std::abs(x) >= 3 ? 0 : 3 * std::sin(a) * std::sin(a / 3) / (a * a);
    }

    std::array<std::array<float, taps>, steps + 1> weights_{};
};

/// Color of an RGB picture, 0 to 255; its border continues outside.
Vec3f color_at(const Raster8& rgb, Vec2f at, const Lanczos& lanczos)
{
    const float x = std::clamp(at.x, 0.0F, static_cast<float>(rgb.width - 1));
    const float y = std::clamp(at.y, 0.0F, static_cast<float>(rgb.height - 1));
    const int left = static_cast<int>(x);
    const int top = static_cast<int>(y);
    const auto& across = lanczos.weights(x - static_cast<float>(left));
    const auto& along = lanczos.weights(y - static_cast<float>(top));
    std::array<std::size_t, Lanczos::taps> columns{};
    for (std::size_t i = 0; i < columns.size(); ++i)
        columns[i] = 3 * static_cast<std::size_t>(std::clamp(left - 2 + static_cast<int>(i), 0, rgb.width - 1));
    Vec3f sum;
    for (std::size_t j = 0; j < along.size(); ++j)
    {
        const std::uint8_t* row = &rgb.at(0, std::clamp(top - 2 + static_cast<int>(j), 0, rgb.height - 1));
        Vec3f mean;
        for (std::size_t i = 0; i < columns.size(); ++i)
        {
            const std::uint8_t* v = row + columns[i];
            mean += Vec3f{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])} * across[i];
        }
        sum += mean * along[j];
    }
    return sum;
}

/// The first texel of `size` whose center is not before texel `at` of `map_size`.
int first_texel(int at, int size, int map_size)
{
    return std::clamp(static_cast<int>(std::ceil(static_cast<double>(at) * size / map_size - 0.5)), 0, size);
}

class Copies
{
  public:
    Copies(const SourceMap& source, const Raster8& rgb, const Mesh& mesh, int size_px, Colors colors, const Progress& progress)
        : source_(source), colors_(colors), mesh_(mesh), charts_(texturing::find_charts(mesh)),
          faces_(texturing::find_texel_faces(mesh, charts_, source.size_px(), progress)), picture_(rgb)
    {
        for (std::size_t size = 0; size < smaller_.size(); ++size)
        {
            const double along_texel = pixels_per_texel(source, rgb.width, size_px) * std::exp2(size);
            const auto side = [along_texel](int pixels)
            { return std::max(1, static_cast<int>(std::lround(pixels / along_texel))); };
            if (along_texel > 1)
                smaller_[size] = resized(rgb, side(rgb.width), side(rgb.height));
            const Raster8& picture = this->picture(size);
            to_picture_[size] = {static_cast<float>(picture.width) / static_cast<float>(source.picture_width),
                                 static_cast<float>(picture.height) / static_cast<float>(source.picture_height)};
        }
    }

    /// As large as copies at a scale of 2^size need it.
    const Raster8& picture(std::size_t size) const { return smaller_[size].empty() ? picture_ : smaller_[size]; }

    bool has(int x, int y) const { return faces_.covered(texel(x, y)) && source_.place(x, y).has_value(); }

    /// \pre has(x, y)
    Meeting around(int x, int y) const
    {
        Meeting result;
        add(x, y, 0, 0, result);
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                if ((dx != 0 || dy != 0) && belongs(x + dx, y + dy, chart(x, y)))
                    add(x + dx, y + dy, dx, dy, result);
        return result;
    }

  private:
    std::size_t texel(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(source_.size_px()) + static_cast<std::size_t>(x);
    }
    std::uint32_t chart(int x, int y) const { return charts_.of_face[faces_.face[texel(x, y)]]; }
    bool belongs(int x, int y, std::uint32_t to) const
    {
        return x >= 0 && y >= 0 && x < source_.size_px() && y < source_.size_px() && has(x, y) && chart(x, y) == to;
    }

    /// The chart shows the surface as a mirror does.
    bool is_mirrored(int x, int y) const
    {
        const Vec2f* uv = &mesh_.texcoords[3 * std::size_t{faces_.face[texel(x, y)]}];
        return cross(uv[1] - uv[0], uv[2] - uv[0]) < 0;
    }

    void add(int x, int y, int dx, int dy, Meeting& meeting) const
    {
        const SourceMap::Place place = *source_.place(x, y);
        const float step = source_.pixels_per_texel * place.scale;
        const float right_x = step * std::cos(place.angle);
        const float right_y = step * std::sin(place.angle);
        const float turn = is_mirrored(x, y) ? -1.0F : 1.0F;
        const auto size = static_cast<std::uint8_t>(
            std::clamp(std::lround(std::log2(place.scale)), 0L, static_cast<long>(smaller_.size()) - 1));
        const Vec2f to_picture = to_picture_[size];
        Copy copy{{place.at.x * to_picture.x - 0.5F, place.at.y * to_picture.y - 0.5F},
                  {right_x * to_picture.x, right_y * to_picture.y},
                  {-turn * right_y * to_picture.x, turn * right_x * to_picture.y},
                  size,
                  colors_ == Colors::painted ? place.shift * 255 : Vec3f{}};
        copy.center = copy.at({static_cast<float>(-dx), static_cast<float>(-dy)});
        const float limit = same_copy * step * to_picture.x;
        std::size_t group = meeting.groups;
        for (std::size_t i = 0; i < meeting.count && group == meeting.groups; ++i)
            if (const Vec2f apart = meeting.copies[i].center - copy.center;
                meeting.copies[i].size == size && dot(apart, apart) <= limit * limit)
                group = meeting.group[i];
        meeting.groups = std::max(meeting.groups, group + 1);
        meeting.size[group] = size;
        meeting.copies[meeting.count] = copy;
        meeting.group[meeting.count] = static_cast<std::uint8_t>(group);
        meeting.neighbor[meeting.count++] = static_cast<std::uint8_t>(3 * (dy + 1) + dx + 1);
    }

    const SourceMap& source_;
    Colors colors_;
    const Mesh& mesh_;
    texturing::Charts charts_;
    texturing::TexelFaces faces_;
    const Raster8& picture_;
    std::array<Raster8, 3> smaller_;  ///< Empty: the picture is as large as it is needed.
    std::array<Vec2f, 3> to_picture_;
};

/// `at`: from the middle texel's center, -0.5 to 0.5 texels of the map.
Vec3f color_at(const Meeting& meeting, const Copies& copies, Vec2f at, const Lanczos& lanczos)
{
    const std::array<float, 3> across = spline_weights(at.x);
    const std::array<float, 3> along = spline_weights(at.y);
    std::array<float, window> weight{};
    std::array<Vec2f, window> place{};
    Vec3f shift;
    float all = 0;
    for (std::size_t i = 0; i < meeting.count; ++i)
    {
        const float w = across[meeting.neighbor[i] % 3] * along[meeting.neighbor[i] / 3];
        weight[meeting.group[i]] += w;
        place[meeting.group[i]] = place[meeting.group[i]] + meeting.copies[i].at(at) * w;
        shift += meeting.copies[i].shift * w;
        all += w;
    }
    const float heaviest = *std::max_element(weight.begin(), weight.begin() + static_cast<std::ptrdiff_t>(meeting.groups));
    Vec3f sum;
    float total = 0;
    for (std::size_t g = 0; g < meeting.groups; ++g)
    {
        const float share = weight[g] / heaviest;
        const float w = share * share * share * share;
        if (w < negligible)
            continue;
        sum += color_at(copies.picture(meeting.size[g]), place[g] * (1 / weight[g]), lanczos) * w;
        total += w;
    }
    // All copies' shifts are mixed: where they meet, the painting's colors are continuous.
    return sum * (1 / total) + shift * (1 / all);
}

}  // namespace

double pixels_per_texel(const SourceMap& source, int picture_width, int size_px)
{
    return double{source.pixels_per_texel} * source.size_px() / size_px * picture_width / source.picture_width;
}

void check_picture(const SourceMap& source, const Raster8& rgb)
{
    if (rgb.channels != 3 && rgb.channels != 4)
        throw Error(fmt::format("the picture on port 'style' has {} channels; expected RGB or RGBA", rgb.channels));
    const double stretch = double{1} * rgb.width * source.picture_height / rgb.height / source.picture_width;
    if (std::abs(stretch - 1) > 0.02)
        throw Error(fmt::format("the style picture has {}x{} pixels, the one that was painted after {}x{}: wire the same "
                                "picture, or a copy of another size",
                                rgb.width, rgb.height, source.picture_width, source.picture_height));
}

Enlarged enlarged(const SourceMap& source, const Raster8& rgb, const Mesh& mesh, int size_px, Colors colors, Progress& progress)
{
    if (rgb.channels == 4)
        return enlarged(source, texturing::opaque_picture(rgb, "port 'style'", progress).rgb, mesh, size_px, colors, progress);
    const int map_px = source.size_px();
    const Lanczos lanczos;
    const Copies copies(source, rgb, mesh, size_px, colors, progress);
    Enlarged result{Raster8(size_px, size_px, 3), 0};
    std::vector<std::uint8_t> is_painted(static_cast<std::size_t>(size_px) * static_cast<std::size_t>(size_px), 0);
    const double step = static_cast<double>(map_px) / size_px;
    const auto paint_texel_of_map = [&](int x, int y)
    {
        const Meeting meeting = copies.around(x, y);
        for (int row = first_texel(y, size_px, map_px); row < first_texel(y + 1, size_px, map_px); ++row)
            for (int column = first_texel(x, size_px, map_px); column < first_texel(x + 1, size_px, map_px); ++column)
            {
                const Vec3f color = color_at(
                    meeting, copies,
                    {static_cast<float>((column + 0.5) * step - x - 0.5), static_cast<float>((row + 0.5) * step - y - 0.5)},
                    lanczos);
                const auto rounded = [](float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0F, 255.0F) + 0.5F); };
                std::uint8_t* out = &result.picture.at(column, row);
                out[0] = rounded(color.x);
                out[1] = rounded(color.y);
                out[2] = rounded(color.z);
                is_painted[result.picture.index(column, row) / 3] = 1;
            }
    };
    parallel_for_each(static_cast<std::size_t>(map_px), "rows", progress,
                      [&](std::size_t row)
                      {
                          const int y = static_cast<int>(row);
                          for (int x = 0; x < map_px; ++x)
                              if (copies.has(x, y))
                                  paint_texel_of_map(x, y);
                      });
    result.painted_share = static_cast<double>(std::count(is_painted.begin(), is_painted.end(), std::uint8_t{1})) /
                           static_cast<double>(is_painted.size());
    texturing::fill_from_nearest(result.picture, is_painted, progress);
    return result;
}

}  // namespace fresco::enlarge
