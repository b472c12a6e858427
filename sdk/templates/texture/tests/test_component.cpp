#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/texture_representation.h>

#include <ATen/ATen.h>

#include "catch.h"

#include <memory>

namespace
{

std::unique_ptr<fresco::TextureRepresentation> made()
{
    auto texture = fresco::testing::make_from_plugin<fresco::TextureRepresentation>(FRESCO_PLUGIN_FILE, "my.plugin");
    fresco::testing::TestFactory factory;
    texture->configure(fresco::Value::Map{{"regularizer", 3.0}}, factory);
    return texture;
}

/// Two pixels: one at the center of texel (1, 0) of 8 x 8, one that sees nothing.
fresco::UvMap two_pixels()
{
    fresco::UvMap map{fresco::RasterF(2, 1, 2), fresco::RasterF(2, 1), fresco::RasterF(2, 1), fresco::Raster8(2, 1)};
    map.uv.values = {1.5F / 8, 1 - 0.5F / 8, 0, 0};
    map.valid.values = {1, 0};
    return map;
}

}  // namespace

TEST_CASE("a picture that was set is looked up again")
{
    const auto texture = made();
    texture->allocate(8);
    fresco::RasterF picture(8, 8, 3);
    picture.at(1, 0, 2) = 0.75F;
    texture->set_picture(picture);
    const auto seen = texture->make_view(two_pixels())->render();
    CHECK(seen[2][0][0].item<float>() == 0.75F);
    CHECK(seen[1][0][0].item<float>() == 0);
    CHECK(seen[2][0][1].item<float>() == 0);
    REQUIRE(texture->to_texture().layers.size() == 2);
    CHECK(texture->to_texture().layers[0] == picture);
}

TEST_CASE("a gradient reaches both images, and the regularizer the fine one")
{
    const auto texture = made();
    texture->allocate(8);
    const auto gradients = texture->make_view(two_pixels())->gradient(at::ones({3, 1, 2}));
    REQUIRE(gradients.size() == 2);
    for (const auto& gradient : gradients)
        CHECK(gradient.values.sum().item<float>() == Approx(3));  // One valid pixel, three channels; lookups' weights sum to 1.
    CHECK(texture->parameters()[0].regularizer == 3);
    CHECK(texture->parameters()[1].regularizer == 0);
    CHECK(texture->parameters()[1].values.size(0) == 16);
}

TEST_CASE("a size that has no half is refused")
{
    CHECK_THROWS_AS(made()->allocate(9), fresco::Error);
    CHECK_THROWS_AS(made()->allocate(2), fresco::Error);
}
