#include "patches.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <vector>

namespace patch_match
{

torch::Tensor extract_patches(const torch::Tensor& picture, const PatchGrid& grid)
{
    const auto source = picture.detach().to(at::kFloat).contiguous();
    auto result = at::empty({grid.count(), patch_values}, at::kFloat);
    float* out = result.data_ptr<float>();
    for (std::int64_t i = 0; i < grid.count(); ++i)
        for (std::int64_t c = 0; c < 3; ++c)
            for (std::int64_t row = 0; row < patch_size; ++row)
                out = std::copy_n(source.data_ptr<float>() + (c * grid.height + grid.y(i) + row) * grid.width + grid.x(i),
                                  patch_size, out);
    return result;
}

torch::Tensor whole_patches(const torch::Tensor& mask, const PatchGrid& grid)
{
    const auto source = mask.contiguous();
    // Sums over rectangles of the mask from its upper left corner.
    const auto pitch = static_cast<std::size_t>(grid.width) + 1;
    std::vector<std::int64_t> sums(pitch * (static_cast<std::size_t>(grid.height) + 1), 0);
    const bool* value = source.data_ptr<bool>();
    for (std::size_t y = 1; y <= static_cast<std::size_t>(grid.height); ++y)
        for (std::size_t x = 1; x < pitch; ++x)
            sums[y * pitch + x] =
                (*value++ ? 1 : 0) + sums[y * pitch + x - 1] + sums[(y - 1) * pitch + x] - sums[(y - 1) * pitch + x - 1];
    auto result = at::empty({grid.count()}, at::kBool);
    for (std::int64_t i = 0; i < grid.count(); ++i)
    {
        const auto upper = static_cast<std::size_t>(grid.y(i)) * pitch + static_cast<std::size_t>(grid.x(i));
        const auto lower = upper + patch_size * pitch;
        result.data_ptr<bool>()[i] =
            sums[lower + patch_size] - sums[lower] - sums[upper + patch_size] + sums[upper] == patch_size * patch_size;
    }
    return result;
}

torch::Tensor halved(const torch::Tensor& picture)
{
    if (picture.size(1) < 2 || picture.size(2) < 2)
        return picture.new_zeros({picture.size(0), picture.size(1) / 2, picture.size(2) / 2});
    return at::avg_pool2d(picture.unsqueeze(0), {2, 2}).squeeze(0);
}

torch::Tensor halved_mask(const torch::Tensor& mask)
{
    const auto height = mask.size(0) / 2;
    const auto width = mask.size(1) / 2;
    return mask.narrow(0, 0, height * 2).narrow(1, 0, width * 2).reshape({height, 2, width, 2}).all(3).all(1);
}

}  // namespace patch_match
