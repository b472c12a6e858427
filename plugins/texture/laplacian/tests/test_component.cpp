#include "plugin_under_test.h"
#include "texture_samples.h"

#include <fresco/error.h>

#include <array>

using namespace texture_samples;

namespace
{

std::unique_ptr<TextureRepresentation> made(const Value& options)
{
    return testing::configured<TextureRepresentation>("texture.laplacian", options);
}

/// Pixel (x, y) looks at the center of texel (x, y).
UvMap identity_map(int size)
{
    UvMap map{RasterF(size, size, 2), RasterF(size, size), RasterF(size, size), Raster8(size, size, 1, 1)};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            map.uv.at(x, y, 0) = (static_cast<float>(x) + 0.5F) / static_cast<float>(size);
            map.uv.at(x, y, 1) = 1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(size);
        }
    return map;
}

}  // namespace

TEST_CASE("set_picture and render give the picture back")
{
    for (const int layers : {1, 2, 4})
    {
        const Value options =
            Value::Map{{"layers_count", layers}, {"regularizer", Value::List(static_cast<std::size_t>(layers), Value(1.0))}};
        const auto texture = made(options);
        texture->allocate(32);
        const auto picture = random_picture(32, 32, 3, 1);
        texture->set_picture(picture);
        const auto rendered = texture->make_view(identity_map(32))->render();
        REQUIRE(rendered.sizes() == at::IntArrayRef({3, 32, 32}));
        const auto values = rendered.accessor<float, 3>();
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x)
                for (int c = 0; c < 3; ++c)
                    CHECK(values[c][y][x] == Approx(picture.at(x, y, c)).margin(2e-6));
    }
}

TEST_CASE("a render is the sum of the layers' lookups, zero where invalid, and to_texture holds the layers")
{
    const auto texture = made(Value::Map{});
    texture->allocate(64);
    texture->set_picture(random_picture(64, 64, 3, 3));
    const auto map = random_map(29, 13, 4);
    const auto rendered = texture->make_view(map)->render();
    const auto layers = texture->to_texture().layers;
    REQUIRE(layers.size() == 4);
    CHECK(layers[3].width == 8);
    const auto values = rendered.accessor<float, 3>();
    for (int y = 0; y < 13; ++y)
        for (int x = 0; x < 29; ++x)
        {
            std::array<float, 3> sum{};
            if (map.valid.at(x, y) != 0)
                for (const auto& layer : layers)
                {
                    std::array<float, 3> value{};
                    sample_bilinear(layer, map.uv.at(x, y, 0), map.uv.at(x, y, 1), value.data());
                    for (std::size_t c = 0; c < 3; ++c)
                        sum[c] += value[c];
                }
            for (int c = 0; c < 3; ++c)
                CHECK(values[c][y][x] == sum[static_cast<std::size_t>(c)]);
        }
}

TEST_CASE("sizes and lists that do not fit are refused")
{
    const auto texture = made(Value::Map{});
    CHECK_THROWS_WITH(texture->allocate(100), Catch::Contains("multiple of 8"));
    CHECK_THROWS_AS(texture->allocate(8), Error);
    CHECK_NOTHROW(texture->allocate(16));
    CHECK(texture->parameters()[1].regularizer == 4);
    CHECK_THROWS_WITH(made(Value::Map{{"layers_count", 1}})->allocate(16), Catch::Contains("regularizer"));
    CHECK_THROWS_AS(texture->set_picture(random_picture(8, 8, 3, 1)), std::invalid_argument);
}

TEST_CASE("layers with corners become layers with centers: a ramp stays a ramp")
{
    const auto texture = made(Value::Map{{"lookup", "corners"}, {"layers_count", 2}, {"regularizer", Value::List{1, 0}}});
    texture->allocate(16);
    // u and v themselves, in the finest layer: texel i at i / 15.
    float* values = texture->parameters()[0].values.data_ptr<float>();
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
        {
            values[3 * (16 * y + x)] = static_cast<float>(x) / 15;
            values[3 * (16 * y + x) + 1] = 1 - static_cast<float>(y) / 15;
        }
    const auto artifact = texture->to_texture();
    const auto shown = texture->make_view(identity_map(16))->render();
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
        {
            const double u = (x + 0.5) / 16;
            const double v = 1 - (y + 0.5) / 16;
            CHECK(artifact.layers[0].at(x, y, 0) == Approx(u));
            CHECK(artifact.layers[0].at(x, y, 1) == Approx(v));
            CHECK(shown[0][y][x].item<float>() == Approx(u));
            CHECK(shown[1][y][x].item<float>() == Approx(v));
        }
    CHECK_THROWS_WITH(texture->set_picture(RasterF(16, 16, 3)), Catch::Contains("lookup") && Catch::Contains("zeros"));
}
