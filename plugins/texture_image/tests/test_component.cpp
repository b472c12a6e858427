#include <catch2/catch.hpp>

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/torch/texture_representation.h>

#include <ATen/Parallel.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <cmath>

using namespace fresco;

namespace
{

std::unique_ptr<TextureRepresentation> made(const Value& options)
{
    auto texture = testing::make_from_plugin<TextureRepresentation>(FRESCO_PLUGIN_FILE, "texture.image");
    testing::TestFactory factory;
    texture->configure(options, factory);
    return texture;
}

RasterF random_picture(int width, int height, int channels, std::uint64_t seed)
{
    Random random(seed);
    RasterF picture(width, height, channels);
    for (auto& value : picture.values)
        value = static_cast<float>(random.uniform());
    return picture;
}

/// uv a little beyond the texture too, a fifth of the pixels invalid.
UvMap random_map(int width, int height, std::uint64_t seed)
{
    UvMap map{random_picture(width, height, 2, seed), RasterF(width, height), RasterF(width, height), Raster8(width, height)};
    for (auto& value : map.uv.values)
        value = value * 1.2F - 0.1F;
    Random random(seed + 1);
    for (auto& value : map.valid.values)
        value = random.uniform() < 0.8 ? 1 : 0;
    return map;
}

/// The weight of texel (column, row) at a uv, in double precision.
double tent(const UvMap& map, int x, int y, int column, int row, int size)
{
    const double tx = std::clamp(static_cast<double>(map.uv.at(x, y, 0)) * size - 0.5, 0.0, size - 1.0);
    const double ty = std::clamp((1 - static_cast<double>(map.uv.at(x, y, 1))) * size - 0.5, 0.0, size - 1.0);
    return std::max(0.0, 1 - std::abs(tx - column)) * std::max(0.0, 1 - std::abs(ty - row));
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
            for (int c = 0; c < 3; ++c)
            {
                upstream[c][y][x] = direction.at(x, y, c);
                double sum = 0;
                for (int row = 0; row < size && map.valid.at(x, y) != 0; ++row)
                    for (int column = 0; column < size; ++column)
                    {
                        const double w = tent(map, x, y, column, row, size);
                        sum += w * static_cast<double>(picture.at(column, row, c));
                        expected[static_cast<std::size_t>(3 * (row * size + column) + c)] +=
                            w * static_cast<double>(direction.at(x, y, c));
                    }
                CHECK(rendered[c][y][x].item<double>() == Approx(sum).margin(1e-6));
            }
    const auto gradients = view->gradient(upstream);
    REQUIRE(gradients.size() == 1);
    auto dense = at::zeros({size * size, 3});
    dense.index_copy_(0, gradients[0].texels, gradients[0].values);
    for (std::int64_t i = 0; i < dense.numel(); ++i)
        CHECK(dense.data_ptr<float>()[i] == Approx(expected[static_cast<std::size_t>(i)]).margin(2e-6));
}

TEST_CASE("views give the same bytes for any number of threads")
{
    const auto texture = made(Value::Map{});
    texture->allocate(100);
    texture->set_picture(random_picture(100, 100, 3, 4));
    const auto view = texture->make_view(random_map(200, 150, 5));
    const int before = at::get_num_threads();
    at::set_num_threads(1);
    const auto picture = view->render();
    const auto gradients = view->gradient(picture);
    at::set_num_threads(3);
    CHECK(at::equal(view->render(), picture));
    CHECK(at::equal(view->gradient(picture)[0].values, gradients[0].values));
    at::set_num_threads(before);
}

TEST_CASE("sizes that do not fit are refused")
{
    const auto texture = made(Value::Map{});
    CHECK_THROWS_WITH(texture->allocate(1), Catch::Contains("2 to 16384"));
    CHECK_THROWS_AS(texture->allocate(16385), Error);
    CHECK_NOTHROW(texture->allocate(2));
    CHECK_THROWS_AS(texture->set_picture(random_picture(3, 3, 3, 1)), std::invalid_argument);
}
