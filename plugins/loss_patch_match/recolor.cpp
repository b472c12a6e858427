#include "recolor.h"

#include <ATen/ATen.h>

#include <array>
#include <vector>

namespace patch_match
{

fresco::ColorMoments color_moments(const torch::Tensor& picture)
{
    const auto values = picture.detach().to(at::kCPU, at::kDouble).contiguous();
    const auto pixels = values.size(1) * values.size(2);
    const double* v = values.data_ptr<double>();
    fresco::ColorMoments moments;
    for (std::int64_t i = 0; i < pixels; ++i)
        moments.add({v[i], v[pixels + i], v[2 * pixels + i]});
    return moments;
}

torch::Tensor recolored(const torch::Tensor& picture, const fresco::ColorMap& map)
{
    const std::array<double, 3> offset{map.offset.x, map.offset.y, map.offset.z};
    std::vector<torch::Tensor> channels;
    for (int row = 0; row < 3; ++row)
        channels.push_back((picture[0] * map.matrix(row, 0) + picture[1] * map.matrix(row, 1) + picture[2] * map.matrix(row, 2) +
                            offset[static_cast<std::size_t>(row)])
                               .clamp(0, 1));
    return at::stack(channels);
}

}  // namespace patch_match
