#include "preview.h"

#include <fresco/files_io.h>
#include <fresco/torch/tensor.h>

#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>

#include <algorithm>
#include <array>
#include <span>

namespace fresco::optimize
{
namespace
{

constexpr int largest_side = 1024;

std::span<float> values_of(const torch::Tensor& tensor)
{
    return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
}

Raster8 displayed(const torch::Tensor& stored, const Raster8& valid, const ValueSpace& space)
{
    const auto result = at::empty_like(stored);
    space.display(values_of(stored), valid.values, values_of(result));
    return to_raster8(result);
}

/// The sum of the layers at `size` x `size` points, as 3 planes.
torch::Tensor collapsed(const Texture& texture, int size)
{
    auto result = at::empty({3, size, size}, at::kFloat);
    float* out = result.data_ptr<float>();
    const auto plane = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            std::array<float, 3> sum{};
            for (const auto& layer : texture.layers)
            {
                std::array<float, 3> value{};
                sample_bilinear(layer, (static_cast<float>(x) + 0.5F) / static_cast<float>(size),
                                1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(size), value.data());
                for (std::size_t c = 0; c < 3; ++c)
                    sum[c] += value[c];
            }
            for (std::size_t c = 0; c < 3; ++c)
                out[c * plane + static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x)] =
                    sum[c];
        }
    return result;
}

}  // namespace

void write_preview(const std::filesystem::path& folder, const ImageIo& images, const ValueSpace& space, const TextureView& view,
                   const Raster8& valid, const TextureRepresentation& texture)
{
    write_file(folder / "view.png", images.encode_png(displayed(view.render(), valid, space)));
    const auto layers = texture.to_texture();
    const int size = std::min(largest_side, layers.size_px());
    write_file(folder / "texture.png", images.encode_png(displayed(collapsed(layers, size), Raster8(size, size, 1, 1), space)));
}

}  // namespace fresco::optimize
