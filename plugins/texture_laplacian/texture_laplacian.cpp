#include "laplacian_layers.h"
#include "layer_view.h"

#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/parallel.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/texture_representation.h>

#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <string>

namespace
{

using fresco::laplacian::LayerView;
using fresco::laplacian::ValidPixels;

constexpr std::size_t pixels_per_piece = 8192;

/// Looks a uv map up in every layer. Holds the layers' tensors, which share memory with the parameters.
class LaplacianView final : public fresco::TextureView
{
  public:
    LaplacianView(const fresco::UvMap& map, const std::vector<fresco::TextureParameter>& parameters,
                  const std::vector<int>& sizes)
        : pixels_(fresco::laplacian::valid_pixels(map))
    {
        for (std::size_t i = 0; i < sizes.size(); ++i)
        {
            values_.push_back(parameters[i].values);
            layers_.emplace_back(pixels_, sizes[i]);
        }
        pixels_.uv = {};
    }

    torch::Tensor render() const override
    {
        torch::Tensor picture = at::zeros({3, pixels_.height, pixels_.width}, at::kFloat);
        float* out = picture.data_ptr<float>();
        const std::size_t plane = plane_size();
        std::vector<float> sums(3 * pixels_.pixels.size());
        fresco::parallel_for(pixels_.pixels.size(), pixels_per_piece, at::get_num_threads(),
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

    std::vector<fresco::SparseGradient> gradient(const torch::Tensor& picture_gradient) const override
    {
        const auto source = picture_gradient.detach().to(at::kCPU, at::kFloat).contiguous();
        if (source.dim() != 3 || source.size(0) != 3 || source.size(1) != pixels_.height || source.size(2) != pixels_.width)
            throw std::invalid_argument("the gradient of a view has the shape of its picture, 3 x H x W");
        const std::vector<float> at_pixels = gathered(source.data_ptr<float>());
        std::vector<fresco::SparseGradient> result;
        for (const auto& layer : layers_)
        {
            const auto texels = layer.texels();
            const auto count = static_cast<std::int64_t>(texels.size());
            fresco::SparseGradient sparse{at::empty({count}, at::kLong), at::empty({count, 3}, at::kFloat)};
            std::copy(texels.begin(), texels.end(), sparse.texels.data_ptr<std::int64_t>());
            float* out = sparse.values.data_ptr<float>();
            fresco::parallel_for(texels.size(), pixels_per_piece, at::get_num_threads(),
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

class TextureLaplacian final : public fresco::TextureRepresentation
{
    fresco::Option<int> layers_count{this, "layers_count", 4, fresco::range(1, 12),
                                     "Layers; layer i has size_px / 2^i texels a side"};
    fresco::Option<std::vector<double>> regulariser{this,
                                                    "regulariser",
                                                    {8, 4, 2, 0},
                                                    fresco::at_least(0),
                                                    "Factor k of each layer's regulariser, finest first; as many as layers"};

  public:
    void allocate(int size_px) override
    {
        if (static_cast<int>(regulariser->size()) != *layers_count)
            throw fresco::Error("option \"regulariser\": " + std::to_string(regulariser->size()) + " numbers for " +
                                std::to_string(*layers_count) + " layers; give one per layer, finest first");
        const int divisor = 1 << (*layers_count - 1);
        if (size_px % divisor != 0 || size_px / divisor < 2 || size_px > 16384)
            throw fresco::Error("a texture of " + std::to_string(size_px) + " texels does not fit " +
                                std::to_string(*layers_count) + " layers; take a multiple of " + std::to_string(divisor) +
                                " from " + std::to_string(2 * divisor) + " to 16384");
        parameters_.clear();
        sizes_.clear();
        for (int i = 0; i < *layers_count; ++i)
        {
            const std::int64_t size = size_px >> i;
            sizes_.push_back(static_cast<int>(size));
            parameters_.push_back({"layer_" + std::to_string(i), at::zeros({size * size, 3}, at::kFloat),
                                   (*regulariser)[static_cast<std::size_t>(i)]});
        }
    }

    void set_picture(const fresco::RasterF& picture) override
    {
        if (sizes_.empty() || picture.width != sizes_.front() || picture.height != sizes_.front() || picture.channels != 3)
            throw std::invalid_argument("set_picture takes S x S x 3 values after allocate(S)");
        const auto layers = fresco::laplacian::laplacian_layers(picture, *layers_count, at::get_num_threads());
        for (std::size_t i = 0; i < layers.size(); ++i)
            std::copy(layers[i].values.begin(), layers[i].values.end(), parameters_[i].values.data_ptr<float>());
    }

    std::vector<fresco::TextureParameter>& parameters() override { return parameters_; }

    std::unique_ptr<fresco::TextureView> make_view(const fresco::UvMap& map) const override
    {
        return std::make_unique<LaplacianView>(map, parameters_, sizes_);
    }

    fresco::Texture to_texture() const override
    {
        fresco::Texture texture;
        for (std::size_t i = 0; i < sizes_.size(); ++i)
        {
            fresco::RasterF layer(sizes_[i], sizes_[i], 3);
            const float* values = parameters_[i].values.data_ptr<float>();
            std::copy(values, values + layer.values.size(), layer.values.begin());
            texture.layers.push_back(std::move(layer));
        }
        return texture;
    }

  private:
    std::vector<fresco::TextureParameter> parameters_;
    std::vector<int> sizes_;
};

}  // namespace

FRESCO_COMPONENT("texture.laplacian", TextureLaplacian, fresco::TextureRepresentation,
                 "Sum of square layers, each half the size of the one before")
