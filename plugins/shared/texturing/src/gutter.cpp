#include <fresco/texturing/gutter.h>

#include <fresco/error.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cstddef>
#include <limits>

namespace fresco::texturing
{
namespace
{
constexpr int no_row = std::numeric_limits<int>::max();
constexpr std::size_t columns_per_block = 64;

/// W x H: the row of the nearest source in the same column, or no_row.
std::vector<int> nearest_rows(const Raster8& image, const std::vector<std::uint8_t>& is_source, const Progress& progress)
{
    const auto width = static_cast<std::size_t>(image.width);
    std::vector<int> rows(is_source.size(), no_row);
    const auto nearer = [](int row, int candidate, int current)
    { return candidate != no_row && (current == no_row || std::abs(candidate - row) < std::abs(current - row)); };
    parallel_for(width, columns_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (int y = 0; y < image.height; ++y)
                         for (std::size_t x = begin; x < end; ++x)
                         {
                             const std::size_t at = static_cast<std::size_t>(y) * width + x;
                             rows[at] = is_source[at] ? y : y > 0 ? rows[at - width] : no_row;
                         }
                     for (int y = image.height - 2; y >= 0; --y)
                         for (std::size_t x = begin; x < end; ++x)
                         {
                             const std::size_t at = static_cast<std::size_t>(y) * width + x;
                             if (nearer(y, rows[at + width], rows[at]))
                                 rows[at] = rows[at + width];
                         }
                 });
    return rows;
}

/// The lower envelope of one parabola per column that holds a source: which column is nearest where along the row.
class Envelope
{
  public:
    explicit Envelope(std::size_t width) : columns_(width), begins_(width) {}

    void build(const int* nearest_row, std::size_t width, int row)
    {
        count_ = 0;
        for (std::size_t x = 0; x < width; ++x)
            if (nearest_row[x] != no_row)
                add(static_cast<double>(x), nearest_row, row);
    }

    /// For x in ascending order; `piece` starts at 0 and is kept by the caller.
    std::size_t column(double x, std::size_t& piece) const
    {
        while (piece + 1 < count_ && begins_[piece + 1] < x)
            ++piece;
        return columns_[piece];
    }

  private:
    void add(double x, const int* nearest_row, int row)
    {
        const auto height = [&](double column)
        {
            const double away = nearest_row[static_cast<std::size_t>(column)] - row;
            return away * away + column * column;
        };
        double begin = -std::numeric_limits<double>::infinity();
        while (count_ > 0)
        {
            const auto last = static_cast<double>(columns_[count_ - 1]);
            begin = (height(x) - height(last)) / (2 * (x - last));
            if (begin > begins_[count_ - 1])
                break;
            --count_;
        }
        if (count_ == 0)
            begin = -std::numeric_limits<double>::infinity();
        columns_[count_] = static_cast<std::size_t>(x);
        begins_[count_++] = begin;
    }

    std::vector<std::size_t> columns_;
    std::vector<double> begins_;
    std::size_t count_ = 0;
};
}  // namespace

void fill_from_nearest(Raster8& image, const std::vector<std::uint8_t>& is_source, const Progress& progress)
{
    if (std::find(is_source.begin(), is_source.end(), std::uint8_t{1}) == is_source.end())
        throw Error("the mesh's charts cover no texel: its texcoords lie outside [0,1] or are all the same");
    const std::vector<int> rows = nearest_rows(image, is_source, progress);
    const auto width = static_cast<std::size_t>(image.width);
    const auto channels = static_cast<std::size_t>(image.channels);
    constexpr std::size_t rows_per_block = 32;
    parallel_for(static_cast<std::size_t>(image.height), rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     Envelope envelope(width);
                     for (std::size_t y = begin; y < end; ++y)
                     {
                         const int* row = &rows[y * width];
                         envelope.build(row, width, static_cast<int>(y));
                         std::size_t piece = 0;
                         for (std::size_t x = 0; x < width; ++x)
                         {
                             if (is_source[y * width + x])
                                 continue;
                             const std::size_t column = envelope.column(static_cast<double>(x), piece);
                             const std::size_t source = static_cast<std::size_t>(row[column]) * width + column;
                             std::copy_n(&image.values[source * channels], channels, &image.values[(y * width + x) * channels]);
                         }
                     }
                 });
}

}  // namespace fresco::texturing
