#include "catch.h"
#include "size_by_distance.h"

#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace fresco;

namespace
{
constexpr double side_m = 0.2;

/// Smooth noise on a plane: values at the nodes of a grid, linear between them.
class SmoothField
{
  public:
    SmoothField(double spacing_m, Random& random) : spacing_(spacing_m)
    {
        for (double& value : nodes_)
            value = random.normal();
    }

    double at(Vec3f p) const
    {
        const double x = double{p.x} / spacing_;
        const double y = double{p.y} / spacing_;
        const int i = static_cast<int>(x);
        const int j = static_cast<int>(y);
        return (node(i, j) * (1 - x + i) + node(i + 1, j) * (x - i)) * (1 - y + j) +
               (node(i, j + 1) * (1 - x + i) + node(i + 1, j + 1) * (x - i)) * (y - j);
    }

  private:
    static constexpr int side = 64;
    double node(int i, int j) const { return nodes_[static_cast<std::size_t>(j * side + i)]; }

    double spacing_;
    std::vector<double> nodes_ = std::vector<double>(std::size_t{side} * side);
};

/// Squares all over a floor of 8 x 8 m.
std::vector<PlacedSize> floor_of(std::size_t count, Random& random, const std::function<double(Vec3f)>& distance,
                                 const std::function<ColoredSize(Vec3f, double)>& strokes)
{
    std::vector<PlacedSize> places;
    for (std::size_t i = 0; i < count; ++i)
    {
        const Vec3f p{static_cast<float>(8 * random.uniform()), static_cast<float>(8 * random.uniform()), 0};
        places.push_back({p, distance(p), strokes(p, distance(p))});
    }
    return places;
}

ColoredSize gray(double size)
{
    return {{50, 0, 0}, size};
}
}  // namespace

TEST_CASE("size by distance: chance takes the correlation as far as its standard error says")
{
    // Neither field knows of the other. Squares overlap, and distances change slowly: 1000 squares are no 1000 samples.
    constexpr int draws = 150;
    for (const double spacing_m : {0.15, 0.6})
    {
        CAPTURE(spacing_m);
        Random random(5);
        double squares = 0;
        double variances = 0;
        for (int draw = 0; draw < draws; ++draw)
        {
            const SmoothField distance(1.5, random);
            const SmoothField size(spacing_m, random);
            const auto places = floor_of(
                300, random, [&](Vec3f p) { return 3 + distance.at(p); }, [&](Vec3f p, double) { return gray(size.at(p)); });
            const SizeByDistance found = size_by_distance(places, {gray(0)}, side_m);
            squares += found.correlation * found.correlation / draws;
            variances += found.standard_error * found.standard_error / draws;
        }
        CHECK(std::sqrt(variances / squares) == Approx(1).margin(0.25));
        if (spacing_m > 0.5)  // The error of independent samples is far too small there.
            CHECK(squares > 2.5 / 300);
    }
}

TEST_CASE("size by distance: the same places again are no more places")
{
    Random random(2);
    const SmoothField distance(1.5, random);
    auto places = floor_of(
        200, random, [&](Vec3f p) { return 3 + distance.at(p); }, [&](Vec3f, double) { return gray(random.normal()); });
    const SizeByDistance once = size_by_distance(places, {gray(0)}, side_m);
    CHECK(once.independent_places() == Approx(200).epsilon(0.4));
    const auto all = places;
    for (int i = 0; i < 4; ++i)
        places.insert(places.end(), all.begin(), all.end());
    const SizeByDistance again = size_by_distance(places, {gray(0)}, side_m);
    CHECK(again.places == 1000);
    CHECK(again.correlation == Approx(once.correlation));
    CHECK(again.independent_places() < 300);
}

TEST_CASE("size by distance: growth is found, constant size is not taken for it")
{
    Random random(3);
    const SmoothField field(1.5, random);
    const auto distance = [&](Vec3f p) { return 3 * std::exp(0.3 * field.at(p)); };
    const auto measured = [&](double growth)
    {
        return size_by_distance(floor_of(1000, random, distance,
                                         [&](Vec3f, double d) { return gray(growth * std::log(d) + 0.15 * random.normal()); }),
                                {gray(0)}, side_m);
    };
    const SizeByDistance constant = measured(0);
    CHECK(std::abs(constant.correlation) < 0.1);
    CHECK(constant.standard_error < 0.05);
    const SizeByDistance grown = measured(1);
    CHECK(grown.correlation > 0.7);
    CHECK(grown.independent_places() > 300);
    // A quarter of growing in proportion.
    const SizeByDistance slight = measured(0.25);
    CHECK(slight.correlation > 0.1 + 2 * slight.standard_error);
}

TEST_CASE("size by distance: broad strokes where their colors fit are not growth")
{
    // The picture's light parts have broad strokes, and what is far away is light.
    Random random(4);
    std::vector<ColoredSize> picture;
    for (int i = 0; i < 500; ++i)
    {
        const double light = 20 + 60 * random.uniform();
        picture.push_back({{static_cast<float>(light), 0, 0}, light / 100 + 0.1 * random.normal()});
    }
    const SmoothField field(1.5, random);
    const auto distance = [&](Vec3f p) { return 3 + field.at(p); };
    const auto places = [&](double growth)
    {
        return floor_of(
            1000, random, distance,
            [&](Vec3f, double d)
            {
                const double light = std::clamp(50 + 15 * (d - 3) + 10 * random.normal(), 20.0, 80.0);
                return ColoredSize{{static_cast<float>(light), 0, 0}, light / 100 + growth * d + 0.1 * random.normal()};
            });
    };
    const auto chosen = places(0);
    CHECK(size_by_distance(chosen, {gray(0)}, side_m).correlation > 0.3);
    CHECK(std::abs(size_by_distance(chosen, picture, side_m).correlation) < 0.1);
    CHECK(size_by_distance(places(0.1), picture, side_m).correlation > 0.4);
}

TEST_CASE("size by distance: undefined for few places or sizes that are all equal")
{
    Random random(6);
    const auto three = floor_of(
        3, random, [](Vec3f p) { return p.x; }, [&](Vec3f, double) { return gray(random.normal()); });
    CHECK(std::isnan(size_by_distance(three, {gray(0)}, side_m).correlation));
    const auto equal = floor_of(
        20, random, [](Vec3f p) { return p.x; }, [](Vec3f, double) { return gray(0.5); });
    CHECK(std::isnan(size_by_distance(equal, {gray(0)}, side_m).correlation));
}
