#include <fresco/texturing/smaller_picture.h>

#include <fresco/parallel.h>
#include <fresco/texturing/charts.h>
#include <fresco/texturing/gutter.h>
#include <fresco/texturing/linear_light.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace fresco::texturing
{
namespace
{

/// Averages the texels of one chart below a texel of the smaller pictures.
class BoxFilter
{
  public:
    BoxFilter(std::span<const Raster8> sources, const TexelFaces& faces, const Charts& charts, int size)
        : sources_(sources), faces_(faces), charts_(charts), scale_(static_cast<double>(faces.size) / size)
    {
        for (std::size_t step = 0; step < light_.size(); ++step)
            light_[step] = to_linear(static_cast<std::uint8_t>(step));
    }

    /// Writes one texel of all pictures; false where the box holds no texel of the chart.
    bool average(int x, int y, std::uint32_t chart, std::span<Raster8> smaller)
    {
        found_.clear();
        double weight = 0;
        const auto [first_row, end_row] = range(y);
        const auto [first_column, end_column] = range(x);
        for (int row = first_row; row < end_row; ++row)
            for (int column = first_column; column < end_column; ++column)
            {
                const auto texel =
                    static_cast<std::size_t>(row) * static_cast<std::size_t>(faces_.size) + static_cast<std::size_t>(column);
                if (faces_.inside[texel] == 0 || charts_.of_face[faces_.face[texel]] != chart)
                    continue;
                found_.emplace_back(texel, overlap(y, row) * overlap(x, column));
                weight += found_.back().second;
            }
        if (weight <= 0)
            return false;
        for (std::size_t i = 0; i < sources_.size(); ++i)
        {
            const auto channels = static_cast<std::size_t>(sources_[i].channels);
            const std::uint8_t* const values = sources_[i].values.data();
            std::array<double, 4> sum{};
            for (const auto& [texel, area] : found_)
                for (std::size_t c = 0; c < channels; ++c)
                    sum[c] += area * light_[values[texel * channels + c]];
            for (std::size_t c = 0; c < channels; ++c)
                smaller[i].at(x, y, static_cast<int>(c)) = from_linear(sum[c] / weight);
        }
        return true;
    }

  private:
    std::pair<int, int> range(int at) const
    {
        return {static_cast<int>(at * scale_), std::min(faces_.size, static_cast<int>(std::ceil((at + 1) * scale_)))};
    }
    /// Of the target texel `at` with the source texel `of`, along one axis.
    double overlap(int at, int of) const { return std::min((at + 1) * scale_, of + 1.0) - std::max(at * scale_, double(of)); }

    std::span<const Raster8> sources_;
    const TexelFaces& faces_;
    const Charts& charts_;
    double scale_;
    std::array<double, 256> light_;                      ///< Of the steps.
    std::vector<std::pair<std::size_t, double>> found_;  ///< The chart's texels in the box, and their areas in it.
};

}  // namespace

std::vector<Raster8> smaller_pictures(const Mesh& mesh, const Charts& charts, const TexelFaces& faces,
                                      std::span<const Raster8> pictures, int max_px, const Progress& progress)
{
    if (max_px == 0 || faces.size <= max_px)
        return {pictures.begin(), pictures.end()};
    const TexelFaces smaller = find_texel_faces(mesh, charts, max_px, progress);
    std::vector<Raster8> results;
    for (const Raster8& picture : pictures)
        results.emplace_back(max_px, max_px, picture.channels);
    std::vector<std::uint8_t> is_source(smaller.face.size(), 0);
    const auto size = static_cast<std::size_t>(max_px);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(size, rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     BoxFilter filter(pictures, faces, charts, max_px);
                     for (std::size_t texel = begin * size; texel < end * size; ++texel)
                         if (smaller.covered(texel))
                             is_source[texel] = filter.average(static_cast<int>(texel % size), static_cast<int>(texel / size),
                                                               charts.of_face[smaller.face[texel]], results);
                 });
    for (Raster8& result : results)
        fill_from_nearest(result, is_source, progress);
    return results;
}

Raster8 smaller_picture(const TexturedMesh& textured, int max_px, const Progress& progress)
{
    const Raster8& picture = textured.image.pixels;
    if (max_px == 0 || picture.width <= max_px)
        return picture;
    const Charts charts = find_charts(textured.mesh);
    const TexelFaces faces = find_texel_faces(textured.mesh, charts, picture.width, progress);
    return std::move(smaller_pictures(textured.mesh, charts, faces, {&picture, 1}, max_px, progress).front());
}

}  // namespace fresco::texturing
