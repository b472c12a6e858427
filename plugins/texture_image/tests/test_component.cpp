#include "texture_samples.h"

#include <fresco/error.h>

#include <ATen/ops/equal.h>
#include <ATen/ops/zeros.h>

using namespace texture_samples;

namespace
{

std::unique_ptr<TextureRepresentation> made(const Value& options)
{
    return texture_samples::made(FRESCO_PLUGIN_FILE, "texture.image", options);
}

}  // namespace

TEST_CASE("texel centers lie at +0.5 and row 0 at the top")
{
    const auto texture = made(Value::Map{{"regularizer", 3.0}});
    texture->allocate(4);
    REQUIRE(texture->parameters().size() == 1);
    CHECK(texture->parameters()[0].regularizer == 3);
    CHECK(at::equal(texture->parameters()[0].values, at::zeros({16, 3})));
    RasterF picture(4, 4, 3);
    picture.at(1, 0, 2) = 8;
    texture->set_picture(picture);
    // The center of texel (1, 0), the corner it shares with (2, 1), and a pixel that is not valid.
    UvMap map{RasterF(3, 1, 2), RasterF(3, 1), RasterF(3, 1), Raster8(3, 1, 1, 1)};
    map.uv.values = {0.375F, 0.875F, 0.5F, 0.75F, 0.375F, 0.875F};
    map.valid.values[2] = 0;
    const auto rendered = texture->make_view(map)->render();
    REQUIRE(rendered.sizes() == at::IntArrayRef({3, 1, 3}));
    CHECK(rendered[2][0][0].item<float>() == 8);
    CHECK(rendered[2][0][1].item<float>() == 2);
    CHECK(rendered[2][0][2].item<float>() == 0);
    CHECK(rendered[0][0][0].item<float>() == 0);
    const auto artifact = texture->to_texture();
    REQUIRE(artifact.layers.size() == 1);
    CHECK(artifact.layers[0] == picture);
}

TEST_CASE("render and gradient agree with sums over all texels in double precision")
{
    const int size = 7;
    const auto texture = made(Value::Map{});
    texture->allocate(size);
    const auto picture = random_picture(size, size, 3, 1);
    texture->set_picture(picture);
    const auto map = random_map(9, 8, 2);
    const auto view = texture->make_view(map);
    const auto rendered = view->render();
    const auto direction = random_picture(9, 8, 3, 3);
    auto upstream = at::zeros({3, 8, 9});
    std::vector<double> expected(static_cast<std::size_t>(3 * size * size));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 9; ++x)
        {
            const auto weights = map.valid.at(x, y) == 0 ? std::map<std::int64_t, double>{}
                                                         : slow_weights(static_cast<double>(map.uv.at(x, y, 0)),
                                                                        static_cast<double>(map.uv.at(x, y, 1)), size);
            for (int c = 0; c < 3; ++c)
            {
                upstream[c][y][x] = direction.at(x, y, c);
                double sum = 0;
                for (const auto& [texel, w] : weights)
                {
                    const auto place = static_cast<std::size_t>(3 * texel + c);
                    sum += w * static_cast<double>(picture.values[place]);
                    expected[place] += w * static_cast<double>(direction.at(x, y, c));
                }
                CHECK(rendered[c][y][x].item<double>() == Approx(sum).margin(1e-6));
            }
        }
    const auto gradients = view->gradient(upstream);
    REQUIRE(gradients.size() == 1);
    auto dense = at::zeros({size * size, 3});
    dense.index_copy_(0, gradients[0].texels, gradients[0].values);
    for (std::int64_t i = 0; i < dense.numel(); ++i)
        CHECK(dense.data_ptr<float>()[i] == Approx(expected[static_cast<std::size_t>(i)]).margin(2e-6));
}

TEST_CASE("sizes that do not fit are refused")
{
    const auto texture = made(Value::Map{});
    CHECK_THROWS_WITH(texture->allocate(1), Catch::Contains("2 to 16384"));
    CHECK_THROWS_AS(texture->allocate(16385), Error);
    CHECK_NOTHROW(texture->allocate(2));
    CHECK_THROWS_AS(texture->set_picture(random_picture(3, 3, 3, 1)), std::invalid_argument);
}
