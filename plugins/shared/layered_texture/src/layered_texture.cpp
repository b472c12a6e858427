#include <fresco/layered_texture/layered_texture.h>

#include "device_view.h"

#include <fresco/layered_texture/layer_view.h>
#include <fresco/parallel.h>
#include <fresco/torch/lazy_tensor.h>

#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <utility>

namespace fresco
{
namespace
{

constexpr std::size_t pixels_per_piece = 8192;

/// Looks a uv map up in every layer. Holds the layers' tensors, which share memory with the parameters.
class LayeredView final : public TextureView
{
  public:
    LayeredView(const UvMap& map, const std::vector<TextureParameter>& parameters, const std::vector<int>& sizes, TexelGrid grid)
        : pixels_(valid_pixels(map))
    {
        for (std::size_t i = 0; i < sizes.size(); ++i)
        {
            values_.push_back(parameters[i].values);
            layers_.emplace_back(pixels_, sizes[i], grid);
        }
        pixels_.uv = {};
    }

    torch::Tensor render() const override
    {
        torch::Tensor picture = at::zeros({3, pixels_.height, pixels_.width}, at::kFloat);
        float* out = picture.data_ptr<float>();
        const std::size_t plane = plane_size();
        std::vector<float> sums(3 * pixels_.pixels.size());
        parallel_for(pixels_.pixels.size(), pixels_per_piece, at::get_num_threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         for (std::size_t layer = 0; layer < layers_.size(); ++layer)
                             layers_[layer].add_lookup(values_[layer].data_ptr<float>(), begin, end, sums.data());
                         for (std::size_t i = begin; i < end; ++i)
                             for (std::size_t c = 0; c < 3; ++c)
                                 out[c * plane + static_cast<std::size_t>(pixels_.pixels[i])] = sums[3 * i + c];
                     });
        return picture;
    }

    std::vector<SparseGradient> gradient(const torch::Tensor& picture_gradient) const override
    {
        const auto source = picture_gradient.detach().to(at::kCPU, at::kFloat).contiguous();
        if (source.dim() != 3 || source.size(0) != 3 || source.size(1) != pixels_.height || source.size(2) != pixels_.width)
            throw std::invalid_argument("the gradient of a view has the shape of its picture, 3 x H x W");
        const std::vector<float> at_pixels = gathered(source.data_ptr<float>());
        std::vector<SparseGradient> result;
        for (const auto& layer : layers_)
        {
            const auto texels = layer.texels();
            const auto count = static_cast<std::int64_t>(texels.size());
            SparseGradient sparse{at::empty({count}, at::kLong), at::empty({count, 3}, at::kFloat)};
            std::copy(texels.begin(), texels.end(), sparse.texels.data_ptr<std::int64_t>());
            float* out = sparse.values.data_ptr<float>();
            parallel_for(texels.size(), pixels_per_piece, at::get_num_threads(),
                         [&](std::size_t begin, std::size_t end) { layer.gather(at_pixels.data(), begin, end, out); });
            result.push_back(std::move(sparse));
        }
        return result;
    }

  private:
    std::size_t plane_size() const { return static_cast<std::size_t>(pixels_.width) * static_cast<std::size_t>(pixels_.height); }

    /// The planes' values at the valid pixels, 3 per pixel.
    std::vector<float> gathered(const float* planes) const
    {
        const std::size_t plane = plane_size();
        std::vector<float> result(3 * pixels_.pixels.size());
        for (std::size_t i = 0; i < pixels_.pixels.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c)
                result[3 * i + c] = planes[c * plane + static_cast<std::size_t>(pixels_.pixels[i])];
        return result;
    }

    ValidPixels pixels_;
    std::vector<torch::Tensor> values_;
    std::vector<LayerView> layers_;
};

/// A layer whose outermost texels lie on the border, looked up at texel centers.
RasterF on_centers(const RasterF& layer)
{
    RasterF result(layer.width, layer.height, layer.channels);
    const float step = static_cast<float>(layer.width - 1) / static_cast<float>(layer.width);
    const auto at = [&](int i)
    {
        const float x = (static_cast<float>(i) + 0.5F) * step;
        const int first = std::min(static_cast<int>(x), layer.width - 2);
        return std::pair(first, x - static_cast<float>(first));
    };
    for (int y = 0; y < layer.height; ++y)
        for (int x = 0; x < layer.width; ++x)
        {
            const auto [column, right] = at(x);
            const auto [row, down] = at(y);
            for (int c = 0; c < layer.channels; ++c)
            {
                const float top = layer.at(column, row, c) * (1 - right) + layer.at(column + 1, row, c) * right;
                const float bottom = layer.at(column, row + 1, c) * (1 - right) + layer.at(column + 1, row + 1, c) * right;
                result.at(x, y, c) = top * (1 - down) + bottom * down;
            }
        }
    return result;
}

}  // namespace

LayeredTexture::~LayeredTexture() = default;

void LayeredTexture::allocate_layers(const std::vector<int>& sizes, const std::vector<double>& regularizer, TexelGrid grid)
{
    parameters_.clear();
    sizes_ = sizes;
    grid_ = grid;
    for (std::size_t i = 0; i < sizes.size(); ++i)
    {
        const std::int64_t size = sizes[i];
        parameters_.push_back({fmt::format("layer_{}", i), lazy_zeros({size * size, 3}, at::kFloat), regularizer.at(i)});
    }
}

void LayeredTexture::check_picture(const RasterF& picture) const
{
    if (sizes_.empty() || picture.width != sizes_.front() || picture.height != sizes_.front() || picture.channels != 3)
        throw std::invalid_argument("set_picture takes S x S x 3 values after allocate(S)");
}

void LayeredTexture::set_layers(const std::vector<RasterF>& layers)
{
    for (std::size_t i = 0; i < parameters_.size(); ++i)
    {
        auto& values = parameters_[i].values;
        const auto near = values.device().is_cpu() ? values : at::empty(values.sizes(), at::kFloat);
        std::copy(layers.at(i).values.begin(), layers[i].values.end(), near.data_ptr<float>());
        // In place: views that exist already look into this memory.
        if (!near.is_same(values))
            values.copy_(near);
    }
}

std::unique_ptr<TextureView> LayeredTexture::make_view(const UvMap& map) const
{
    if (!parameters_.empty() && !parameters_[0].values.device().is_cpu())
        return std::make_unique<DeviceView>(map, parameters_, sizes_, grid_);
    return std::make_unique<LayeredView>(map, parameters_, sizes_, grid_);
}

bool LayeredTexture::move_to(const torch::Device& device)
{
    for (auto& parameter : parameters_)
        parameter.values = parameter.values.to(device);
    return true;
}

Texture LayeredTexture::to_texture() const
{
    Texture texture;
    for (std::size_t i = 0; i < sizes_.size(); ++i)
    {
        RasterF layer(sizes_[i], sizes_[i], 3);
        const auto source = parameters_[i].values.to(at::kCPU);
        const float* values = source.data_ptr<float>();
        std::copy(values, values + layer.values.size(), layer.values.begin());
        texture.layers.push_back(grid_ == TexelGrid::centers ? std::move(layer) : on_centers(layer));
    }
    return texture;
}

}  // namespace fresco
