#pragma once

#include "convolution.h"

#include <fresco/weights/vgg19.h>

#include <cstdint>

/// \file What lies between the convolutions, on maps with their channels innermost, forward and back.

namespace vgg19
{

enum class Pooling
{
    max,
    average
};

/// C x H x W -> H x W x C.
void from_planes(const float* planes, MapsShape shape, float* maps, const Parallel& parallel);

/// 2 x 2 pixels become one: floor(H / 2) x floor(W / 2) x C. `chosen` (unless null; only for max pooling): of the four, row by
/// row, which was the largest, the first of equal ones.
void pool(const float* maps, MapsShape shape, Pooling pooling, float* out, std::uint8_t* chosen, const Parallel& parallel);

/// Gradients of maps as rows of pixels that may lie in a wider picture.
struct GradientView
{
    const float* values = nullptr;  ///< Of the first pixel.
    std::size_t row = 0;            ///< Values from one row to the next.
};

/// Adds what reached the frame of one pixel round H x W x C gradients, in (H + 2) x (W + 2) x C values, to the pixels that Border
/// `reflect` took it from; returns the H x W pixels.
GradientView folded(float* framed, int height, int width, int channels);

/// Gradients that came together at H x W x C responses -> out, where mask is 1, else 0: of the responses themselves (`own`, null:
/// none), and of the next convolution's input, which is these responses, …
void add_masked(MapsShape shape, const float* own, GradientView of_next, const std::uint8_t* mask, float* out,
                const Parallel& parallel);
/// … or these responses pooled; `chosen` as pool() gave it. `of_next` may be none only in add_masked.
void add_unpooled(MapsShape shape, const float* own, GradientView of_next, Pooling pooling, const std::uint8_t* chosen,
                  const std::uint8_t* mask, float* out, const Parallel& parallel);

}  // namespace vgg19
