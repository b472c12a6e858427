#include <fresco/uv_mapping/cracks.h>

#include <limits>

namespace fresco
{

bool seen_through_crack(const RasterF& met, int x, int y)
{
    if (x < 1 || y < 1 || x + 1 >= met.width || y + 1 >= met.height)
        return false;
    const float depth = met.at(x, y);
    if (!(depth < std::numeric_limits<float>::infinity()))
        return false;
    const auto before = [&](int dx, int dy) { return depth > met.at(x + dx, y + dy) + crack_depth_m; };
    // The left one first: it answers for nearly every pixel.
    return before(-1, 0) && before(1, 0) && before(-1, -1) && before(0, -1) && before(1, -1) && before(-1, 1) && before(0, 1) &&
           before(1, 1);
}

}  // namespace fresco
