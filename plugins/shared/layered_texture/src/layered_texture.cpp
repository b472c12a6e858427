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
#include <string>
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

/// Where coordinates in [0,1] fall between the texels of one axis: the first (int32) and the share of the one after it.
std::pair<torch::Tensor, torch::Tensor> place(const torch::Tensor& coordinate, int size, TexelGrid grid)
{
    const auto texels = grid == TexelGrid::centers ? coordinate * size - 0.5 : coordinate * (size - 1);
    const auto x = texels.clamp(0, size - 1);
    const auto first = x.to(at::kInt).clamp_max(size - 2);
    return {first, x - first};
}

/// Looks a uv map up in every layer by libtorch's operators, where the parameters lie: what LayerView does, with the same sums in
/// the same order. Making it waits for the current stream, looking up and gathering do not. Holds the layers' tensors, which
/// share memory with the parameters. Memory: about 50 bytes per valid pixel and layer, and 16 per touched texel.
class DeviceView final : public TextureView
{
  public:
    DeviceView(const UvMap& map, const std::vector<TextureParameter>& parameters, const std::vector<int>& sizes, TexelGrid grid)
    {
        const auto valid = valid_pixels(map);
        width_ = valid.width;
        height_ = valid.height;
        const auto device = parameters.at(0).values.device();
        pixels_ = sent_to(as_tensor<std::int64_t>(valid.pixels, at::kLong), device);
        const auto uv = sent_to(as_tensor<float>(valid.uv, at::kFloat), device).view({-1, 2});
        for (std::size_t i = 0; i < sizes.size(); ++i)
            layers_.push_back(layer(uv, parameters[i].values, sizes[i], grid));
    }

    torch::Tensor render() const override
    {
        const at::NoGradGuard no_gradient;
        auto sums = at::zeros({pixels_.numel(), 3}, pixels_.options().dtype(at::kFloat));
        for (const auto& layer : layers_)
        {
            const auto left = 1 - layer.right;
            const auto row = [&](int below)
            {
                const auto upper = layer.base + below;
                return layer.values.index_select(0, upper).mul_(left).add_(
                    layer.values.index_select(0, upper + 1).mul_(layer.right));
            };
            sums.add_(row(0).mul_(1 - layer.down).add_(row(layer.size).mul_(layer.down)));
        }
        return at::zeros({3, height_ * width_}, sums.options()).index_copy_(1, pixels_, sums.t()).view({3, height_, width_});
    }

    std::vector<SparseGradient> gradient(const torch::Tensor& picture_gradient) const override
    {
        const at::NoGradGuard no_gradient;
        if (picture_gradient.dim() != 3 || picture_gradient.size(0) != 3 || picture_gradient.size(1) != height_ ||
            picture_gradient.size(2) != width_)
            throw std::invalid_argument("the gradient of a view has the shape of its picture, 3 x H x W");
        const auto at_pixels =
            sent_to(picture_gradient.to(at::kFloat), pixels_.device()).reshape({3, -1}).index_select(1, pixels_).t().contiguous();
        std::vector<SparseGradient> result;
        for (const auto& layer : layers_)
        {
            const auto shares = at_pixels.index_select(0, layer.pixels).mul_(layer.weights);
            // Without its checks, which would have to wait. One sum after the other within a texel, so that no order is left
            // open.
            result.push_back({layer.texels, at::segment_reduce(shares, "sum", {}, {}, layer.offsets, 0, true)});
        }
        return result;
    }

  private:
    struct Layer
    {
        int size = 0;
        torch::Tensor values;   ///< S² x 3
        torch::Tensor base;     ///< V, int32: the upper left texel of each valid pixel.
        torch::Tensor right;    ///< V x 1: the share of the right texels …
        torch::Tensor down;     ///< … and of the lower ones.
        torch::Tensor texels;   ///< T, int64: touched, ascending.
        torch::Tensor offsets;  ///< T + 1, int64: where each one's lookups begin.
        torch::Tensor pixels;   ///< L, int32: of each lookup, texel by texel.
        torch::Tensor weights;  ///< L x 1
    };
    static Layer layer(const torch::Tensor& uv, const torch::Tensor& values, int size, TexelGrid grid)
    {
        const auto [column, right] = place(uv.select(1, 0), size, grid);
        const auto [row, down] = place(1 - uv.select(1, 1), size, grid);
        Layer result;
        result.size = size;
        result.values = values;
        result.base = row * size + column;
        result.right = right.unsqueeze(1);
        result.down = down.unsqueeze(1);

        const auto& base = result.base;
        const auto texels = at::stack({base, base + 1, base + size, base + (size + 1)}, 1).flatten();
        const auto left = 1 - right;
        const auto up = 1 - down;
        const auto weights = at::stack({left * up, right * up, left * down, right * down}, 1).flatten();
        const auto used = (weights > 0).nonzero().flatten();
        const auto [sorted, order] = at::sort(texels.index_select(0, used), true, 0, false);
        const auto lookups = used.index_select(0, order);
        const auto [touched, inverse, counts] = at::unique_consecutive(sorted, false, true, 0);
        result.texels = touched.to(at::kLong);
        result.offsets = at::cat({at::zeros({1}, counts.options()), counts.cumsum(0)});
        result.pixels = lookups.div(4, "floor").to(at::kInt);
        result.weights = weights.index_select(0, lookups).unsqueeze(1);
        return result;
    }

    std::int64_t width_ = 0;
    std::int64_t height_ = 0;
    torch::Tensor pixels_;  ///< V, int64: the valid ones.
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
        return numerics::Between<float>{first, first + 1, x - static_cast<float>(first)};
    };
    for (int y = 0; y < layer.height; ++y)
        for (int x = 0; x < layer.width; ++x)
            for (int c = 0; c < layer.channels; ++c)
                result.at(x, y, c) = numerics::bilinear(at(x), at(y), [&](int u, int v) { return layer.at(u, v, c); });
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
