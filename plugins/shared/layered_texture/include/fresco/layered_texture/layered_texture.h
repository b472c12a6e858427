#pragma once

#include <fresco/layered_texture/layer_view.h>
#include <fresco/torch/texture_representation.h>

#include <memory>
#include <vector>

namespace fresco
{

/// A texture whose value at uv is the sum over square layers of a bilinear lookup: row 0 at v = 1, and unless said otherwise
/// texel centers at +0.5, clamped at the borders (sample_bilinear to the last bit). A representation derives from it and says
/// which layers there are.
///
/// Layers are lazy_zeros(): of a texture that begins with zeros, the pages that are written take memory.
///
/// A view costs its valid pixels, not the layers: about 90 bytes per valid pixel and layer. Its gradient gathers, for each
/// touched texel, its lookups in the order of the pixels: no atomics, the same bytes for any number of threads. On another device
/// than the CPU the same is done by libtorch's operators.
class LayeredTexture : public TextureRepresentation
{
  public:
    std::vector<TextureParameter>& parameters() override { return parameters_; }
    bool move_to(const torch::Device& device) override;
    std::unique_ptr<TextureView> make_view(const UvMap& map) const override;
    Texture to_texture() const override;

  protected:
    static constexpr int largest_size_px = 16384;

    /// Layers of zeros, `sizes` texels a side (2 to largest_size_px), finest first, with their factors k of the regularizer.
    /// With TexelGrid::corners to_texture() resamples them bilinearly onto texel centers, where a texture artifact has its
    /// values.
    void allocate_layers(const std::vector<int>& sizes, const std::vector<double>& regularizer,
                         TexelGrid grid = TexelGrid::centers);
    /// Throws std::invalid_argument unless `picture` has the finest layer's size and 3 channels.
    void check_picture(const RasterF& picture) const;
    /// Sets all layers; `layers` have their sizes and 3 channels.
    void set_layers(const std::vector<RasterF>& layers);

  private:
    std::vector<TextureParameter> parameters_;
    torch::Tensor together_;  ///< On another device than the CPU: what the parameters are parts of, in their order.
    std::vector<int> sizes_;
    TexelGrid grid_ = TexelGrid::centers;
};

}  // namespace fresco
