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

}  // namespace

Raster8 smaller_picture(const TexturedMesh& textured, int max_px, const Progress& progress)
{
    const Raster8& source = textured.image.pixels;
    if (max_px == 0 || source.width <= max_px)
        return source;
    const Charts charts = find_charts(textured.mesh);
    const auto chart_of = own_charts(find_texel_faces(textured.mesh, charts, source.width, progress), charts);
    const TexelFaces faces = find_texel_faces(textured.mesh, charts, max_px, progress);
    const BoxFilter filter(source, chart_of, max_px);

    Raster8 result(max_px, max_px, source.channels);
    std::vector<std::uint8_t> is_source(faces.face.size(), 0);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(static_cast<std::size_t>(max_px), rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t y = begin; y < end; ++y)
                         for (int x = 0; x < max_px; ++x)
                         {
                             const std::size_t texel = y * static_cast<std::size_t>(max_px) + static_cast<std::size_t>(x);
                             if (faces.covered(texel))
                                 is_source[texel] =
                                     filter.average(x, static_cast<int>(y), charts.of_face[faces.face[texel]],
                                                    &result.values[texel * static_cast<std::size_t>(source.channels)]);
                         }
                 });
    fill_from_nearest(result, is_source, progress);
    return result;
}

}  // namespace fresco::texturing
