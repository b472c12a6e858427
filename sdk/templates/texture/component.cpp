#include <fresco/error.h>
#include <fresco/layered_texture/layered_texture.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>

#include <string>

namespace
{

/// The sum of one square image and of a second one, half as large, which spreads color to texels that few frames see.
class MyPlugin final : public fresco::LayeredTexture
{
    fresco::Option<double> regularizer{this, "regularizer", 1.0, fresco::at_least(0),
                                       "Factor k of the larger image's regularizer"};

  public:
    void allocate(int size_px) override
    {
        if (size_px < 4 || size_px % 2 != 0)
            throw fresco::Error("a texture of " + std::to_string(size_px) +
                                " texels cannot be halved; take an even number from 4 on");
        // Finest first, each half as large as the one before, with its factor in the regularizer. Lookups and their gradients are
        // LayeredTexture's.
        allocate_layers({size_px, size_px / 2}, {*regularizer, 0});
    }

    void set_picture(const fresco::RasterF& picture) override
    {
        check_picture(picture);
        set_layers({picture, fresco::RasterF(picture.width / 2, picture.height / 2, 3)});
    }
};

}  // namespace

FRESCO_COMPONENT("my.plugin", MyPlugin, fresco::TextureRepresentation, "An image and one of half its size, added")
