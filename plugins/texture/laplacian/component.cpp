#include "laplacian_layers.h"

#include <fresco/error.h>
#include <fresco/layered_texture/layered_texture.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>

#include <ATen/Parallel.h>

#include <fmt/format.h>
#include <string>

namespace
{

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
        set_layers(fresco::laplacian::laplacian_layers(picture, *layers_count, at::get_num_threads()));
    }
};

}  // namespace

FRESCO_COMPONENT("texture.laplacian", TextureLaplacian, fresco::TextureRepresentation,
                 "Sum of square layers, each half the size of the one before")
