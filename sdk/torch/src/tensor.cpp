#include <fresco/torch/tensor.h>

#include <ATen/ops/empty.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fresco
{
namespace
{

/// H x W x C values to C x H x W, each through `convert`.
template <class From, class Convert>
torch::Tensor planes(const Raster<From>& picture, Convert convert)
{
    const std::int64_t channels = picture.channels;
    const std::int64_t pixels = std::int64_t{picture.width} * picture.height;
    at::Tensor tensor = at::empty({channels, picture.height, picture.width}, at::kFloat);
    float* out = tensor.data_ptr<float>();
    for (std::int64_t c = 0; c < channels; ++c)
        for (std::int64_t i = 0; i < pixels; ++i)
            out[c * pixels + i] = convert(picture.values[static_cast<std::size_t>(i * channels + c)]);
    return tensor;
}

}  // namespace

torch::Tensor sent_to(const torch::Tensor& tensor, const torch::Device& device)
{
    if (device.is_cpu() || !tensor.device().is_cpu())
        return tensor.to(device);
    if (tensor.numel() == 0)
        return at::empty(tensor.sizes(), tensor.options().device(device));
    // From other memory CUDA copies while the processor waits, and it waits for everything sent before.
    const auto source = device.is_cuda() ? tensor.contiguous().pin_memory() : tensor;
    return source.to(source.options().device(device), true);
}

torch::Tensor to_tensor(const Raster8& picture)
{
    return planes(picture, [](std::uint8_t v) { return static_cast<float>(v) / 255.0F; });
}

torch::Tensor to_tensor(const RasterF& picture)
{
    return planes(picture, [](float v) { return v; });
}

Raster8 to_raster8(const torch::Tensor& picture)
{
    if (picture.dim() != 3)
        throw std::invalid_argument("a picture tensor has the shape C x H x W");
    const auto source = picture.detach().to(at::kCPU, at::kFloat).contiguous();
    const std::int64_t channels = source.size(0);
    const std::int64_t pixels = source.size(1) * source.size(2);
    Raster8 raster(static_cast<int>(source.size(2)), static_cast<int>(source.size(1)), static_cast<int>(channels));
    const float* in = source.data_ptr<float>();
    for (std::int64_t c = 0; c < channels; ++c)
        for (std::int64_t i = 0; i < pixels; ++i)
        {
            // std::clamp would pass NaN on, and converting NaN is undefined.
            const float v = in[c * pixels + i];
            const float level = v >= 0 ? std::min(v, 1.0F) * 255.0F : 0.0F;
            raster.values[static_cast<std::size_t>(i * channels + c)] = static_cast<std::uint8_t>(std::lround(level));
        }
    return raster;
}

}  // namespace fresco
