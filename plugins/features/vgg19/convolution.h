#pragma once

/// \file What a VGG needs on the CPU without libtorch, forward and back: 3x3 convolutions by minimal filtering, and the pooling
/// and masks between them, on maps with their channels innermost. For encoder.h.

#include "winograd_kernel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace vgg19
{

/// Does work(begin, end) for pieces of [0, count), on as many threads as it likes.
using Parallel = std::function<void(std::size_t count, const std::function<void(std::size_t begin, std::size_t end)>& work)>;

/// Continuation of a picture beyond its border.
enum class Border
{
    zero,
    reflect  ///< Without the outermost row or column; where there is only one, that one again.
};

/// Maps as rows of pixels with their channels innermost.
struct MapsShape
{
    int height = 0;
    int width = 0;
    int channels = 0;  ///< A multiple of 16.

    std::size_t pixels() const { return static_cast<std::size_t>(height) * static_cast<std::size_t>(width); }
    std::size_t size() const { return pixels() * static_cast<std::size_t>(channels); }
    /// Index of a pixel's first value.
    std::size_t offset(int y, int x) const
    {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels);
    }
    /// 2 x 2 pixels become one; an odd last row or column is left out.
    MapsShape halved() const { return {height / 2, width / 2, channels}; }
};

/// Destinations of the rectified responses of a convolution; null skips one.
struct Responses
{
    float* maps = nullptr;
    std::uint8_t* masks = nullptr;   ///< 1 where they are positive.
    float* pooled = nullptr;         ///< The largest of 2 x 2 of them: floor(H / 2) x floor(W / 2) x C.
    std::uint8_t* chosen = nullptr;  ///< The number of the largest, row by row, the first of equal ones; 4: all are 0.
};

/// Gradients as rows of pixels that may lie in a wider picture.
struct GradientView
{
    const float* values = nullptr;  ///< Values of the first pixel.
    std::size_t row = 0;            ///< Values from one row to the next.
};

/// Gradients that come together at H x W x C rectified responses.
struct ResponseGradient
{
    const float* own = nullptr;  ///< Gradient of the responses themselves; null: none.
    GradientView
        of_next;  ///< Gradient of the next convolution's input: the responses, or with `chosen` these pooled. Null: none.
    const std::uint8_t* masks = nullptr;   ///< Responses::masks; may be null with `chosen` and without `own`.
    const std::uint8_t* chosen = nullptr;  ///< Responses::chosen; null if not pooled.
};

/// A line of a cache, as long as the widest vector.
struct alignas(64) Line
{
    std::array<float, 16> values;
};

/// A frozen convolution with 3 x 3 filters and stride 1 by minimal filtering F(6x6, 3x3) (Winograd 1980; Lavin and Gray, CVPR
/// 2016): a fifth of the direct way's multiplications, and a relative difference of some 5e-6 to it. The result does not depend
/// on the threads. Immutable: use it on any thread.
class Convolution3x3
{
  public:
    /// Whether to convolve, or to take the gradient of the output back to the input: filters turned round, inputs and outputs
    /// swapped.
    enum class Way
    {
        there,
        back
    };
    /// `weights`: outputs x inputs x 3 x 3 of the way there; channels are filled up with zeros to multiples of 16. The kernel is
    /// the fastest that this processor can run unless one is given.
    Convolution3x3(std::span<const float> weights, int outputs, int inputs, Way way = Way::there,
                   const winograd::Kernel& kernel = fastest_kernel());

    static const winograd::Kernel& fastest_kernel();

    int inputs() const { return inputs_; }    ///< Filled up.
    int outputs() const { return outputs_; }  ///< Filled up.

    /// Response plus bias (outputs() values), rectified, of the size of `in`. Tiles without a pixel of `needed` (of the
    /// response's size, null: all of it) are left out, and become 0.
    void rectified(const float* in, MapsShape shape, Border border, const float* bias, const Responses& out,
                   const Parallel& parallel, const std::uint8_t* needed = nullptr) const;
    /// Computes the input's gradient on `beyond` more pixels on each side (0 or 1): (H + 2 beyond) x (W + 2 beyond).
    void back(const ResponseGradient& gradient, MapsShape shape, int beyond, float* out, const Parallel& parallel,
              const std::uint8_t* needed = nullptr) const;

  private:
    struct Corner;
    struct Job;
    struct Block;
    /// Outputs that are multiplied together.
    struct Panel
    {
        std::size_t first;
        std::size_t width;
    };

    Panel panel_of(std::size_t number) const;
    void run(Job job, const std::uint8_t* needed, const Parallel& parallel) const;
    Block block_of(std::size_t first, std::size_t last, std::vector<Line>& values) const;
    void transform(const Job& job, const Block& block, std::size_t first, std::size_t last) const;
    template <class Tile, class TileOf, class Transform>
    void each_tile(const Block& block, std::size_t first, std::size_t last, const TileOf& tile_of,
                   const Transform& transform) const;
    void multiply(const Job& job, const Block& block, const Panel& panel) const;
    void transform_back(const Job& job, Corner tile, const Panel& panel, const float* products, std::size_t stride) const;

    const winograd::Kernel* kernel_;
    int terms_;  ///< Inputs that are not filled up.
    int inputs_;
    int outputs_;
    std::vector<Line> filters_;  ///< Panels x 64 positions x terms x (a panel's outputs).
};

/// C x H x W -> H x W x C.
void from_planes(const float* planes, MapsShape shape, float* maps, const Parallel& parallel);

/// Adds what reached the frame of one pixel round H x W x C gradients, in (H + 2) x (W + 2) x C values, to the pixels that Border
/// `reflect` took it from; returns the H x W pixels.
GradientView folded(float* framed, int height, int width, int channels);

}  // namespace vgg19
