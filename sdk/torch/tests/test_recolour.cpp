#include <catch2/catch.hpp>

#include <fresco/torch/recolour.h>

#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <cmath>

using namespace fresco;

namespace
{

double number(std::uint64_t& state)
{
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11U) / 9007199254740992.0;
}

/// Correlated colours around `centre`.
at::Tensor cloud(std::int64_t count, Vec3d centre, double spread, std::uint64_t seed)
{
    auto picture = at::empty({3, count}, at::kDouble);
    auto out = picture.accessor<double, 2>();
    for (std::int64_t i = 0; i < count; ++i)
    {
        const double a = number(seed) - 0.5;
        const double b = number(seed) - 0.5;
        const double c = number(seed) - 0.5;
        out[0][i] = centre.x + spread * a;
        out[1][i] = centre.y + spread * (0.6 * a + 0.5 * b);
        out[2][i] = centre.z + spread * (0.2 * a - 0.7 * b + 0.3 * c);
    }
    return picture;
}

}  // namespace

TEST_CASE("moments of a picture and of its masked part")
{
    auto picture = at::zeros({3, 1, 2}, at::kFloat);
    picture[0][0][1] = 1;
    auto mask = at::zeros({1, 2}, at::kBool);
    mask[0][1] = true;
    CHECK(color_moments(picture).mean() == (Vec3d{0.5, 0, 0}));
    CHECK(color_moments(picture, mask).mean() == (Vec3d{1, 0, 0}));
}

TEST_CASE("recoloured applies the map pixel by pixel and clamps")
{
    const auto picture = cloud(100, {0.4, 0.5, 0.6}, 0.3, 2).reshape({3, 10, 10});
    const ColorMap map{Mat3{{2, 0, 0, 0, 1, 0.5, 0, 0.25, 1}}, {-0.5, 0.1, 0}};
    const auto result = recoloured(picture, map);
    REQUIRE(result.sizes() == picture.sizes());
    const auto in = picture.accessor<double, 3>();
    const auto out = result.accessor<double, 3>();
    for (int y = 0; y < 10; ++y)
        for (int x = 0; x < 10; ++x)
        {
            const auto expected = map(Vec3d{in[0][y][x], in[1][y][x], in[2][y][x]});
            CHECK(out[0][y][x] == Approx(std::clamp(expected.x, 0.0, 1.0)).margin(1e-12));
            CHECK(out[1][y][x] == Approx(std::clamp(expected.y, 0.0, 1.0)).margin(1e-12));
            CHECK(out[2][y][x] == Approx(std::clamp(expected.z, 0.0, 1.0)).margin(1e-12));
        }
}
