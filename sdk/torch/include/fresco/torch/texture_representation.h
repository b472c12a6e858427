#pragma once

#include <fresco/component.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <torch/types.h>

#include <memory>
#include <string>
#include <vector>

namespace fresco
{

/// One block of unknowns: N texels of 3 values.
struct TextureParameter
{
    std::string name;
    torch::Tensor values;    ///< N x 3, float32, contiguous; changed in place by the optimizer rule. On the CPU, but see move_to.
    double regularizer = 0;  ///< k_i of the pyramid (StyleMesh, section 3.1): the loss has λ_r k_i mean(values²).
};

/// The gradient of a step for one parameter, on the texels that the view touches.
struct SparseGradient
{
    torch::Tensor texels;  ///< n, int64, ascending, unique: rows of values.
    torch::Tensor values;  ///< n x 3, float32. Both lie where the parameter does.
};

/// One uv map made ready for lookups (texel numbers and weights).
class TextureView
{
  public:
    virtual ~TextureView();
    /// 3 x H x W in stored values; 0 where the uv map is invalid. Where the parameters lie, as d loss / d picture has to.
    virtual torch::Tensor render() const = 0;
    /// One entry per parameter, for d loss / d picture of 3 x H x W. Sums run in a fixed order.
    virtual std::vector<SparseGradient> gradient(const torch::Tensor& picture_gradient) const = 0;
};

/// How a texture is stored while it is optimized. Used by one thread, except make_view (a loader thread).
class TextureRepresentation : public Component
{
  public:
    static constexpr std::string_view component_kind = "texture";
    ~TextureRepresentation() override;

    /// Makes a texture of S x S texels, all zero. Throws Error for a size that does not fit (layers need S divisible).
    virtual void allocate(int size_px) = 0;
    /// Between allocate() and everything else: the parameters move to `device`, and whatever views need lies there too. On
    /// another device than the CPU make_view may use the current stream of its thread. Returns false, and nothing moves, where
    /// the representation cannot; the default can only stay on the CPU.
    virtual bool move_to(const torch::Device& device);
    /// Sets the unknowns so that the lookup gives `picture` (S x S x 3, row 0 = top).
    virtual void set_picture(const RasterF& picture) = 0;
    virtual std::vector<TextureParameter>& parameters() = 0;
    virtual std::unique_ptr<TextureView> make_view(const UvMap& map) const = 0;
    /// The layers as an artifact, `values` and `seen` left to the caller.
    virtual Texture to_texture() const = 0;
};

}  // namespace fresco
