#include <fresco/torch/recolour.h>

#include <ATen/ops/stack.h>

#include <array>
#include <stdexcept>
#include <vector>

namespace fresco
{

ColorMoments color_moments(const torch::Tensor& picture, const torch::Tensor& mask)
{
    if (picture.dim() < 2 || picture.size(0) != 3)
        throw std::invalid_argument("color_moments takes a tensor of 3 x H x W or 3 x N");
    const auto values = picture.detach().to(at::kCPU, at::kDouble).reshape({3, -1}).contiguous();
    const auto pixels = values.size(1);
    at::Tensor chosen;
    if (mask.defined())
    {
        if (mask.scalar_type() != at::kBool || mask.numel() != pixels)
            throw std::invalid_argument("color_moments takes a mask of one bool per pixel");
        chosen = mask.to(at::kCPU).reshape({-1}).contiguous();
    }
    const double* v = values.data_ptr<double>();
    const bool* use = chosen.defined() ? chosen.data_ptr<bool>() : nullptr;
    ColorMoments moments;
    for (std::int64_t i = 0; i < pixels; ++i)
        if (use == nullptr || use[i])
            moments.add(Vec3d{v[i], v[pixels + i], v[2 * pixels + i]});
    return moments;
}

torch::Tensor recoloured(const torch::Tensor& picture, const ColorMap& map)
{
    if (picture.dim() < 2 || picture.size(0) != 3)
        throw std::invalid_argument("recoloured takes a tensor of 3 x H x W or 3 x N");
    const std::array<double, 3> offset{map.offset.x, map.offset.y, map.offset.z};
    std::vector<at::Tensor> channels;
    for (int row = 0; row < 3; ++row)
        channels.push_back((picture[0] * map.matrix(row, 0) + picture[1] * map.matrix(row, 1) + picture[2] * map.matrix(row, 2) +
                            offset[static_cast<std::size_t>(row)])
                               .clamp(0, 1));
    return at::stack(channels);
}

}  // namespace fresco
