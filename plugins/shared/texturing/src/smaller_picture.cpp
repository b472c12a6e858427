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

/// S x S: the chart whose own a texel is, or TexelFaces::none.
std::vector<std::uint32_t> own_charts(const TexelFaces& faces, const Charts& charts)
{
    std::vector<std::uint32_t> result(faces.face.size(), TexelFaces::none);
    for (std::size_t texel = 0; texel < result.size(); ++texel)
        if (faces.inside[texel])
            result[texel] = charts.of_face[faces.face[texel]];
    return result;
}

/// Averages the texels of one chart below a texel of the smaller picture.
class BoxFilter
{
  public:
    BoxFilter(const Raster8& source, const std::vector<std::uint32_t>& chart_of, int size)
        : source_(source), chart_of_(chart_of), scale_(static_cast<double>(source.width) / size)
    {
    }

    /// False where the box holds no texel of the chart.
    bool average(int x, int y, std::uint32_t chart, std::uint8_t* out) const
    {
        std::array<double, 4> sum{};
        double weight = 0;
        const auto channels = static_cast<std::size_t>(source_.channels);
        const auto [first_row, end_row] = range(y);
        const auto [first_column, end_column] = range(x);
        for (int row = first_row; row < end_row; ++row)
            for (int column = first_column; column < end_column; ++column)
            {
                const auto texel =
                    static_cast<std::size_t>(row) * static_cast<std::size_t>(source_.width) + static_cast<std::size_t>(column);
                if (chart_of_[texel] != chart)
                    continue;
                const double area = overlap(y, row) * overlap(x, column);
                weight += area;
                for (std::size_t c = 0; c < channels; ++c)
                    sum[c] += area * to_linear(source_.values[texel * channels + c]);
            }
        if (weight <= 0)
            return false;
        for (std::size_t c = 0; c < channels; ++c)
            out[c] = from_linear(sum[c] / weight);
        return true;
    }

  private:
    std::pair<int, int> range(int at) const
    {
        return {static_cast<int>(at * scale_), std::min(source_.width, static_cast<int>(std::ceil((at + 1) * scale_)))};
    }
    /// Of the target texel `at` with the source texel `of`, along one axis.
    double overlap(int at, int of) const { return std::min((at + 1) * scale_, of + 1.0) - std::max(at * scale_, double(of)); }

    const Raster8& source_;
    const std::vector<std::uint32_t>& chart_of_;
    double scale_;
};

/// `faces`: of the smaller picture.
Raster8 reduced(const Raster8& source, const std::vector<std::uint32_t>& chart_of, const Charts& charts, const TexelFaces& faces,
                const Progress& progress)
{
    const auto size = static_cast<std::size_t>(faces.size);
    const auto channels = static_cast<std::size_t>(source.channels);
    const BoxFilter filter(source, chart_of, faces.size);
    Raster8 result(faces.size, faces.size, source.channels);
    std::vector<std::uint8_t> is_source(faces.face.size(), 0);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(size, rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t texel = begin * size; texel < end * size; ++texel)
                         if (faces.covered(texel))
                             is_source[texel] =
                                 filter.average(static_cast<int>(texel % size), static_cast<int>(texel / size),
                                                charts.of_face[faces.face[texel]], &result.values[texel * channels]);
                 });
    fill_from_nearest(result, is_source, progress);
    return result;
}

}  // namespace

std::vector<Raster8> smaller_pictures(const Mesh& mesh, const Charts& charts, const TexelFaces& faces,
                                      std::span<const Raster8> pictures, int max_px, const Progress& progress)
{
    if (max_px == 0 || faces.size <= max_px)
        return {pictures.begin(), pictures.end()};
    const auto chart_of = own_charts(faces, charts);
    const TexelFaces smaller = find_texel_faces(mesh, charts, max_px, progress);
    std::vector<Raster8> results;
    for (const Raster8& picture : pictures)
        results.push_back(reduced(picture, chart_of, charts, smaller, progress));
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
