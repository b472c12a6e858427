#include <fresco/error.h>
#include <fresco/layered_texture/layered_texture.h>
#include <fresco/option.h>
#include <fresco/parallel.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <ATen/Parallel.h>

#include <array>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace
{

/// Subtracts from `target` the lookup of `coarse` at the centers of target's texels.
void subtract_lookup(fresco::RasterF& target, const fresco::RasterF& coarse)
{
    const auto size = static_cast<float>(target.width);
    fresco::parallel_for(static_cast<std::size_t>(target.height), 16, at::get_num_threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             std::array<float, 4> value{};
                             for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                                 for (int x = 0; x < target.width; ++x)
                                 {
                                     fresco::sample_bilinear(coarse, (static_cast<float>(x) + 0.5F) / size,
                                                             1 - (static_cast<float>(y) + 0.5F) / size, value.data());
                                     for (int c = 0; c < target.channels; ++c)
                                         target.at(x, y, c) -= value[static_cast<std::size_t>(c)];
                                 }
                         });
}

/// Splits an S x S x C picture into `count` layers of size S / 2^i, finest first: each coarse layer holds what the ones below it
/// lack of the area-averaged picture, and the finest the residual, so that the sum of bilinear lookups at the finest texel
/// centers is the picture to rounding (Burt and Adelson, "The Laplacian pyramid as a compact image code", 1983). S must be
/// divisible by 2^(count-1). The result does not depend on the threads.
std::vector<fresco::RasterF> laplacian_layers(const fresco::RasterF& picture, int count)
{
    std::vector<fresco::RasterF> layers{picture};
    for (int i = 1; i < count; ++i)
        layers.push_back(fresco::resized(layers.back(), layers.back().width / 2, layers.back().height / 2));
    for (std::size_t i = layers.size() - 1; i-- > 0;)
        for (std::size_t coarser = layers.size() - 1; coarser > i; --coarser)
            subtract_lookup(layers[i], layers[coarser]);
    return layers;
}

class TextureLaplacian final : public fresco::LayeredTexture
{
    fresco::Option<int> layers_count{this, "layers_count", 4, fresco::range(1, 12),
                                     "Layers; layer i has size_px / 2^i texels a side"};
    fresco::Option<std::vector<double>> regularizer{this,
                                                    "regularizer",
                                                    {8, 4, 2, 0},
                                                    fresco::at_least(0),
                                                    "Factor k of each layer's regularizer, finest first; one per layer"};

    fresco::Option<std::string> lookup{this, "lookup", "centers", fresco::one_of({"centers", "corners"}),
                                       "Texel i of S lies at (i + 0.5) / S, or at i / (S - 1)"};

  public:
    void allocate(int size_px) override
    {
        if (static_cast<int>(regularizer->size()) != *layers_count)
            throw fresco::Error(
                fmt::format("option \"regularizer\": {} numbers for {} layers; expected one per layer, finest first",
                            regularizer->size(), *layers_count));
        const int divisor = 1 << (*layers_count - 1);
        if (size_px % divisor != 0 || size_px / divisor < 2 || size_px > largest_size_px)
            throw fresco::Error(
                fmt::format("a texture of {} texels does not fit {} layers; set size_px to a multiple of {} from {} to {}",
                            size_px, *layers_count, divisor, 2 * divisor, largest_size_px));
        std::vector<int> sizes;
        for (int i = 0; i < *layers_count; ++i)
            sizes.push_back(size_px >> i);
        allocate_layers(sizes, *regularizer, *lookup == "corners" ? fresco::TexelGrid::corners : fresco::TexelGrid::centers);
    }

    void set_picture(const fresco::RasterF& picture) override
    {
        check_picture(picture);
        if (*lookup == "corners")
            throw fresco::Error("option \"lookup\": corners needs a texture that starts with zeros; set init: zeros");
        set_layers(laplacian_layers(picture, *layers_count));
    }
};

}  // namespace

FRESCO_COMPONENT("texture.laplacian", TextureLaplacian, fresco::TextureRepresentation,
                 "Sum of square layers, each half the size of the one before")
