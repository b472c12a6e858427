#include <fresco/layered_texture/layer_view.h>
#include <fresco/layered_texture/layered_texture.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>
#include <fresco/torch/tensor.h>
#include <fresco/torch/tensor_memory.h>
#include <fresco/torch/texture_representation.h>
#include <fresco/uv_maps.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>
#include <vector>

namespace fresco
{

namespace
{

template <class To, class From>
torch::Tensor as_tensor(const std::vector<From>& values, at::ScalarType type)
{
    auto tensor = at::empty({std::ssize(values)}, type);
    std::copy(values.begin(), values.end(), tensor.template data_ptr<To>());
    return tensor;
}

void check_shape(const torch::Tensor& gradient, std::int64_t width, std::int64_t height)
{
    if (gradient.sizes() != at::IntArrayRef({3, height, width}))
        throw std::invalid_argument("the gradient of a view has the shape of its picture, 3 x H x W");
}

/// Positions of coordinates in [0,1] between the texels of one axis: the first texel (int32) and the weight of the next.
std::pair<torch::Tensor, torch::Tensor> place(const torch::Tensor& coordinate, int size, TexelGrid grid)
{
    const auto texels = grid == TexelGrid::centers ? coordinate * size - 0.5 : coordinate * (size - 1);
    const auto x = texels.clamp(0, size - 1);
    const auto first = x.to(at::kInt).clamp_max(size - 2);
    return {first, x - first};
}

/// Looks a uv map up in every layer by libtorch's operators, where the parameters lie: what LayerView does, with the same sums of
/// gradients in the same order. All layers at once: what an operator takes to begin counts more than what it does. Making it
/// waits for the current stream, looking up and gathering do not. Memory: about 256 bytes per valid pixel for four layers, and 16
/// per touched texel.
class DeviceView final : public TextureView
{
  public:
    /// `values`: all layers' texels, one layer after the other; shares memory with the parameters.
    DeviceView(const UvMap& map, torch::Tensor values, const std::vector<int>& sizes, TexelGrid grid) : values_(std::move(values))
    {
        const auto valid = valid_pixels(map);
        width_ = valid.width;
        height_ = valid.height;
        const auto device = values_.device();
        pixels_ = sent_to(as_tensor<std::int64_t>(valid.pixels, at::kLong), device);
        find_lookups(sent_to(as_tensor<float>(valid.uv, at::kFloat), device).view({-1, 2}), sizes, grid);
        sort_lookups(sizes);
    }

    torch::Tensor render() const override
    {
        const at::NoGradGuard no_gradient;
        const auto layers = std::ssize(layers_);
        const auto sums =
            values_.index_select(0, texels_).mul_(weights_).view({layers, pixels_.numel(), 4, 3}).sum(at::IntArrayRef{0, 2});
        return at::zeros({3, height_ * width_}, sums.options()).index_copy_(1, pixels_, sums.t()).view({3, height_, width_});
    }

    std::vector<SparseGradient> gradient(const torch::Tensor& picture_gradient) const override
    {
        const at::NoGradGuard no_gradient;
        check_shape(picture_gradient, width_, height_);
        const auto planes = sent_to(picture_gradient.to(at::kFloat), pixels_.device()).reshape({3, -1});
        const auto shares = planes.t().index_select(0, sorted_places_).mul_(sorted_weights_);
        // Without its checks, which would have to wait. One sum after the other within a texel, so that no order is left open.
        const auto sums = at::segment_reduce(shares, "sum", {}, {}, offsets_, 0, true);
        std::vector<SparseGradient> result;
        for (const auto& layer : layers_)
            result.push_back({layer.touched, sums.narrow(0, layer.first, layer.touched.numel())});
        return result;
    }

  private:
    struct Layer
    {
        torch::Tensor touched;   ///< T, int64: its texels that are looked up, ascending.
        std::int64_t first = 0;  ///< Their first index among those of all layers.
    };

    void find_lookups(const torch::Tensor& uv, const std::vector<int>& sizes, TexelGrid grid)
    {
        std::vector<torch::Tensor> texels;
        std::vector<torch::Tensor> weights;
        std::int64_t begin = 0;
        for (const int size : sizes)
        {
            const auto [column, right] = place(uv.select(1, 0), size, grid);
            const auto [row, down] = place(1 - uv.select(1, 1), size, grid);
            const auto base = row * size + column + begin;
            const auto left = 1 - right;
            const auto up = 1 - down;
            texels.push_back(at::stack({base, base + 1, base + size, base + (size + 1)}, 1).flatten());
            weights.push_back(at::stack({left * up, right * up, left * down, right * down}, 1).flatten());
            begin += std::int64_t{size} * size;
        }
        texels_ = at::cat(texels);
        weights_ = at::cat(weights).unsqueeze(1);
    }

    void sort_lookups(const std::vector<int>& sizes)
    {
        const auto used = (weights_ > 0).flatten().nonzero().flatten();
        const auto [sorted, order] = at::sort(texels_.index_select(0, used), true, 0, false);
        const auto lookups = used.index_select(0, order);
        const auto [touched, inverse, counts] = at::unique_consecutive(sorted, false, true, 0);
        offsets_ = at::cat({at::zeros({1}, counts.options()), counts.cumsum(0)});
        const auto number = lookups.div(4, "floor").remainder(std::max<std::int64_t>(1, pixels_.numel()));
        sorted_places_ = pixels_.index_select(0, number).to(at::kInt);
        sorted_weights_ = weights_.index_select(0, lookups);
        std::vector<std::int64_t> ends;
        std::int64_t end = 0;
        for (const int size : sizes)
            ends.push_back(end += std::int64_t{size} * size);
        const auto all = touched.to(at::kLong);
        const auto last = at::searchsorted(all, at::tensor(ends, at::kLong).to(all.device())).cpu();
        std::int64_t first = 0;
        for (std::size_t i = 0; i < sizes.size(); ++i)
        {
            const auto next = last[static_cast<std::int64_t>(i)].item<std::int64_t>();
            layers_.push_back({all.narrow(0, first, next - first) - (i > 0 ? ends[i - 1] : 0), first});
            first = next;
        }
    }

    torch::Tensor values_;
    std::int64_t width_ = 0;
    std::int64_t height_ = 0;
    torch::Tensor pixels_;   ///< V, int64: the valid ones.
    torch::Tensor texels_;   ///< 4 V for each layer, int32: which texels a pixel is made of …
    torch::Tensor weights_;  ///< … and of how much of each, x 1.
    // The lookups of more than nothing, L, texel by texel:
    torch::Tensor sorted_places_;   ///< L, int32: their pixels' places in the picture.
    torch::Tensor sorted_weights_;  ///< L x 1
    torch::Tensor offsets_;         ///< int64: where each touched texel's begin, and the end.
    std::vector<Layer> layers_;
};

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
        pixels_.uv = std::vector<float>();
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
        check_shape(source, pixels_.width, pixels_.height);
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
        return numerics::Between<float>{first, first + 1, x - static_cast<float>(first)};
    };
    for (int y = 0; y < layer.height; ++y)
        for (int x = 0; x < layer.width; ++x)
            for (int c = 0; c < layer.channels; ++c)
                result.at(x, y, c) = numerics::bilinear(at(x), at(y), [&](int u, int v) { return layer.at(u, v, c); });
    return result;
}

}  // namespace

void LayeredTexture::allocate_layers(const std::vector<int>& sizes, const std::vector<double>& regularizer, TexelGrid grid)
{
    parameters_.clear();
    together_ = torch::Tensor();
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
        return std::make_unique<DeviceView>(map, together_, sizes_, grid_);
    return std::make_unique<LayeredView>(map, parameters_, sizes_, grid_);
}

bool LayeredTexture::move_to(const torch::Device& device)
{
    if (device.is_cpu())
        return true;
    std::int64_t count = 0;
    for (const auto& parameter : parameters_)
        count += parameter.values.size(0);
    together_ = at::empty({count, 3}, torch::TensorOptions(device).dtype(at::kFloat));
    std::int64_t first = 0;
    for (auto& parameter : parameters_)
    {
        const auto there = together_.narrow(0, first, parameter.values.size(0));
        there.copy_(parameter.values);
        first += parameter.values.size(0);
        parameter.values = there;
    }
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
