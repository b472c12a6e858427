#include "measure.h"

#include <cmath>
#include <limits>

using namespace fresco;

namespace
{
constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

double value_at(const Raster8& picture, const Lookup& at, int channel)
{
    const double top = picture.at(at.x0, at.y0, channel) * (1 - at.share_x) + picture.at(at.x1, at.y0, channel) * at.share_x;
    const double bottom = picture.at(at.x0, at.y1, channel) * (1 - at.share_x) + picture.at(at.x1, at.y1, channel) * at.share_x;
    return top * (1 - at.share_y) + bottom * at.share_y;
}

/// The mean of a measure of differences on the scale 0..255.
class DifferenceMean
{
  public:
    explicit DifferenceMean(Protocol protocol) : squared_(protocol == Protocol::released) {}
    void add(double difference)
    {
        sum_ += squared_ ? difference * difference : std::abs(difference) / 255;
        ++count_;
    }
    double value() const { return count_ == 0 ? undefined : sum_ / static_cast<double>(count_); }

  private:
    bool squared_;
    double sum_ = 0;
    std::size_t count_ = 0;
};

double gray(const Raster8& picture, int x, int y)
{
    return 0.299 * picture.at(x, y, 0) + 0.587 * picture.at(x, y, 1) + 0.114 * picture.at(x, y, 2);
}
}  // namespace

double reprojection_difference(const Raster8& source, const Raster8& target, const std::vector<Match>& matches, Protocol protocol)
{
    DifferenceMean mean(protocol);
    for (const Match& match : matches)
        for (int c = 0; c < 3; ++c)
            mean.add(source.at(match.x, match.y, c) - value_at(target, match.target, c));
    return mean.value();
}

double forward_difference(const Raster8& source, const std::vector<Match>& matches, Protocol protocol)
{
    DifferenceMean mean(protocol);
    for (const Match& match : matches)
        for (int c = 0; c < 3; ++c)
        {
            const int here = source.at(match.x, match.y, c);
            if (match.x + 1 < source.width)
                mean.add(source.at(match.x + 1, match.y, c) - here);
            if (match.y + 1 < source.height)
                mean.add(source.at(match.x, match.y + 1, c) - here);
        }
    return mean.value();
}

double sharpness(const Raster8& source, const std::vector<Match>& matches)
{
    double sum = 0;
    double squares = 0;
    std::size_t count = 0;
    for (const Match& match : matches)
    {
        const int x = match.x;
        const int y = match.y;
        if (x < 1 || y < 1 || x + 1 >= source.width || y + 1 >= source.height)
            continue;
        const double laplacian = gray(source, x - 1, y) + gray(source, x + 1, y) + gray(source, x, y - 1) +
                                 gray(source, x, y + 1) - 4 * gray(source, x, y);
        sum += laplacian;
        squares += laplacian * laplacian;
        ++count;
    }
    if (count == 0)
        return undefined;
    const double mean = sum / static_cast<double>(count);
    return squares / static_cast<double>(count) - mean * mean;
}
