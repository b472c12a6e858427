#pragma once

#include <fresco/layered_texture/layer_view.h>
#include <fresco/torch/texture_representation.h>
#include <fresco/uv_maps.h>

#include <vector>

namespace fresco
{

/// Looks a uv map up in every layer by libtorch's operators, where the parameters lie: what LayerView does, with the same sums in
/// the same order. Making it waits for the current stream, looking up and gathering do not. Holds the layers' tensors, which
/// share memory with the parameters. Memory: about 50 bytes per valid pixel and layer, and 16 per touched texel.
class DeviceView final : public TextureView
{
  public:
    DeviceView(const UvMap& map, const std::vector<TextureParameter>& parameters, const std::vector<int>& sizes, TexelGrid grid);

    torch::Tensor render() const override;
    std::vector<SparseGradient> gradient(const torch::Tensor& picture_gradient) const override;

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
    static Layer layer(const torch::Tensor& uv, const torch::Tensor& values, int size, TexelGrid grid);

    std::int64_t width_ = 0;
    std::int64_t height_ = 0;
    torch::Tensor pixels_;  ///< V, int64: the valid ones.
    std::vector<Layer> layers_;
};

}  // namespace fresco
