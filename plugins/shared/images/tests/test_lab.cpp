#include "catch.h"

#include <fresco/images/lab.h>
#include <fresco/random.h>

#include <cmath>
#include <vector>

using namespace fresco;

namespace
{
bool near(Vec3f a, Vec3f b, float margin)
{
    return std::abs(a.x - b.x) < margin && std::abs(a.y - b.y) < margin && std::abs(a.z - b.z) < margin;
}
}  // namespace

TEST_CASE("known colors in CIE L*a*b*")
{
    CHECK(near(lab_from_rgb({0, 0, 0}), {0, 0, 0}, 0.01F));
    CHECK(near(lab_from_rgb({1, 1, 1}), {100, 0, 0}, 0.02F));
    CHECK(near(lab_from_rgb({1, 0, 0}), {53.24F, 80.09F, 67.20F}, 0.05F));
    CHECK(near(lab_from_rgb({0, 1, 0}), {87.73F, -86.18F, 83.18F}, 0.05F));
    CHECK(near(lab_from_rgb({0, 0, 1}), {32.30F, 79.20F, -107.86F}, 0.05F));
    CHECK(near(lab_from_rgb({0.5F, 0.5F, 0.5F}), {53.39F, 0, 0}, 0.02F));
}

TEST_CASE("every color comes back from L*a*b*, and those outside the gamut are clamped")
{
    for (float r = 0; r <= 1; r += 0.125F)
        for (float g = 0; g <= 1; g += 0.125F)
            for (float b = 0; b <= 1; b += 0.125F)
                CHECK(near(rgb_from_lab(lab_from_rgb({r, g, b})), {r, g, b}, 1e-3F));
    const Vec3f outside = rgb_from_lab({100, 120, -120});
    CHECK((outside.x <= 1 && outside.y >= 0 && outside.z <= 1));
}

TEST_CASE("a picture's pixels are converted one by one")
{
    Raster8 picture(2, 1, 3);
    picture.values = {255, 0, 0, 10, 200, 77};
    const RasterF lab = lab_picture(picture);
    const Vec3f second = lab_from_rgb(Vec3f{10 / 255.0F, 200 / 255.0F, 77 / 255.0F});
    CHECK(near({lab.at(1, 0, 0), lab.at(1, 0, 1), lab.at(1, 0, 2)}, second, 1e-3F));
}

namespace
{

double largest_difference(const Mat3& a, const Mat3& b)
{
    double largest = 0;
    for (std::size_t i = 0; i < 9; ++i)
        largest = std::max(largest, std::abs(a.m[i] - b.m[i]));
    return largest;
}

/// Correlated colors around `center`.
std::vector<Vec3d> cloud(int count, Vec3d center, double spread, std::uint64_t seed)
{
    Random random(seed);
    std::vector<Vec3d> colors;
    for (int i = 0; i < count; ++i)
    {
        const double a = random.uniform() - 0.5;
        const double b = random.uniform() - 0.5;
        const double c = random.uniform() - 0.5;
        colors.push_back(center + Vec3d{a, 0.6 * a + 0.5 * b, 0.2 * a - 0.7 * b + 0.3 * c} * spread);
    }
    return colors;
}

ColorMoments moments_of(const std::vector<Vec3d>& colors)
{
    ColorMoments result;
    for (const Vec3d color : colors)
        result.add(color);
    return result;
}

}  // namespace

TEST_CASE("eigenvalues of a symmetric matrix rebuild it")
{
    Random random(1);
    for (int round = 0; round < 200; ++round)
    {
        Mat3 a;
        for (int row = 0; row < 3; ++row)
            for (int column = row; column < 3; ++column)
                a(row, column) = a(column, row) = random.uniform() * 2 - 1;
        if (round == 0)
            a = Mat3{};
        if (round == 1)
            a = Mat3{{0, 0, 0, 0, 0, 0, 0, 0, 0}};
        if (round == 2)
            a = Mat3{{1, 1, 1, 1, 1, 1, 1, 1, 1}};
        const auto eigen = symmetric_eigen(a);
        CHECK(eigen.values.x <= eigen.values.y);
        CHECK(eigen.values.y <= eigen.values.z);
        CHECK(largest_difference(transposed(eigen.vectors) * eigen.vectors, Mat3{}) < 1e-14);
        const Mat3 diagonal{{eigen.values.x, 0, 0, 0, eigen.values.y, 0, 0, 0, eigen.values.z}};
        CHECK(largest_difference(eigen.vectors * diagonal * transposed(eigen.vectors), a) < 1e-14);
    }
}

TEST_CASE("moments of four colors by hand")
{
    ColorMoments moments;
    moments.add(Vec3d{0, 0, 1});
    moments.add(Vec3d{2, 0, 1});
    ColorMoments others;
    others.add(Vec3d{0, 4, 1});
    others.add(Vec3d{2, 4, 1});
    moments.add(others);
    CHECK(moments.count() == 4);
    CHECK(moments.mean() == (Vec3d{1, 2, 1}));
    CHECK(largest_difference(moments.covariance(), Mat3{{1, 0, 0, 0, 4, 0, 0, 0, 0}}) < 1e-15);
}

TEST_CASE("the map gives the mean and covariance of its target, and is symmetric and positive")
{
    const auto from = moments_of(cloud(5000, {0.4, 0.5, 0.6}, 0.3, 2));
    const auto to = moments_of(cloud(5000, {0.7, 0.3, 0.2}, 0.5, 3));
    const auto map = monge_kantorovich(from, to);
    const Vec3d mean = map(from.mean());
    CHECK(length(mean - to.mean()) < 1e-12);
    CHECK(largest_difference(map.matrix * from.covariance() * transposed(map.matrix), to.covariance()) < 1e-12);
    CHECK(largest_difference(map.matrix, transposed(map.matrix)) < 1e-12);
    CHECK(symmetric_eigen(map.matrix).values.x > 0);
}

TEST_CASE("a flat picture is shifted, not amplified, and an empty one is unchanged")
{
    const auto flat = moments_of(std::vector<Vec3d>(10, {0.5, 0.5, 0.5}));
    const auto to = moments_of(cloud(500, {0.7, 0.3, 0.2}, 0.5, 3));
    const auto map = monge_kantorovich(flat, to);
    CHECK(length(map(Vec3d{0.5, 0.5, 0.5}) - to.mean()) < 1e-12);
    CHECK(symmetric_eigen(map.matrix).values.z < 0.5 / 0.01);
    CHECK(monge_kantorovich(ColorMoments{}, to).matrix == Mat3{});
    CHECK(monge_kantorovich(flat, ColorMoments{}).offset == (Vec3d{}));
}
