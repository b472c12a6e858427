#include <fresco/error.h>
#include <fresco/layered_texture/layered_texture.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>

#include <fmt/format.h>

namespace
{

class TextureImage final : public fresco::LayeredTexture
{
    fresco::Option<double> regularizer{this, "regularizer", 0.0, fresco::at_least(0), "Factor k of the regularizer"};

  public:
    void allocate(int size_px) override
    {
        if (size_px < 2 || size_px > largest_size_px)
            throw fresco::Error(fmt::format("size_px is {}; expected 2 to {}", size_px, largest_size_px));
        allocate_layers({size_px}, {*regularizer});
    }

    void set_picture(const fresco::RasterF& picture) override
    {
        check_picture(picture);
        set_layers({picture});
    }
};

}  // namespace

FRESCO_COMPONENT("texture.image", TextureImage, fresco::TextureRepresentation, "One square image")
