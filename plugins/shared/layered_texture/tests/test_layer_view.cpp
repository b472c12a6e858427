#include "texture_samples.h"

#include <fresco/texture.h>

#include <array>
#include <functional>
#include <limits>
#include <utility>

using namespace texture_samples;

TEST_CASE("a lookup is sample_bilinear to the last bit")
{
    for (const int size : {2, 3, 16, 256})
    {
        const auto map = random_map(23, 17, 1);
        const auto layer = random_picture(size, size, 3, 2);
        const auto pixels = valid_pixels(map);
        const LayerView view(pixels, size);
        std::vector<float> out(3 * pixels.pixels.size());
        view.add_lookup(layer.values.data(), 0, pixels.pixels.size(), out.data());
        for (std::size_t i = 0; i < pixels.pixels.size(); ++i)
        {
            std::array<float, 3> expected{};
            sample_bilinear(layer, pixels.uv[2 * i], pixels.uv[2 * i + 1], expected.data());
            for (std::size_t c = 0; c < 3; ++c)
                CHECK(out[3 * i + c] == expected[c]);
        }
    }
}

TEST_CASE("gather is the transpose of the lookup, and its texels are unique and ascending")
{
    for (const auto& [size, grid] :
         {std::pair(2, TexelGrid::centers), std::pair(5, TexelGrid::centers), std::pair(64, TexelGrid::centers),
          std::pair(2, TexelGrid::corners), std::pair(37, TexelGrid::corners)})
    {
        const auto map = random_map(31, 19, 3);
        const auto pixels = valid_pixels(map);
        const LayerView view(pixels, size, grid);
        std::vector<float> gradient(3 * pixels.pixels.size());
        Random random(4);
        for (auto& g : gradient)
            g = static_cast<float>(random.uniform() - 0.5);
        std::map<std::int64_t, std::array<double, 3>> expected;
        for (std::size_t i = 0; i < pixels.pixels.size(); ++i)
            for (const auto& [texel, weight] : slow_weights(pixels.uv[2 * i], pixels.uv[2 * i + 1], size, grid))
                for (std::size_t c = 0; c < 3; ++c)
                    expected[texel][c] += weight * static_cast<double>(gradient[3 * i + c]);
        const auto touched = view.texels();
        std::vector<float> out(3 * touched.size());
        view.gather(gradient.data(), 0, touched.size() / 2, out.data());
        view.gather(gradient.data(), touched.size() / 2, touched.size(), out.data());
        CHECK(std::ranges::adjacent_find(touched, std::greater_equal{}) == touched.end());
        std::size_t found = 0;
        for (std::size_t t = 0; t < touched.size(); ++t)
        {
            const auto twin = expected.find(touched[t]);
            // A weight of 1e-7 is zero in one precision and not in the other.
            const std::array<double, 3> sums = twin == expected.end() ? std::array<double, 3>{} : twin->second;
            found += twin == expected.end() ? 0 : 1;
            for (std::size_t c = 0; c < 3; ++c)
                CHECK(out[3 * t + c] == Approx(sums[c]).margin(2e-5));
        }
        CHECK(found + 2 >= expected.size());
    }
}

TEST_CASE("a uv that is not finite is refused where it counts")
{
    auto map = random_map(3, 3, 6);
    map.uv.values[10] = std::numeric_limits<float>::quiet_NaN();
    map.valid.values[5] = 0;
    CHECK_NOTHROW(valid_pixels(map));
    map.valid.values[5] = 1;
    CHECK_THROWS_WITH(valid_pixels(map), Catch::Contains("2, 1"));
}
