#include "catch.h"
#include "cleaning.h"
#include "splat_scenes.h"

using namespace scan_splats;
using namespace splat_scenes;

TEST_CASE("cleaning removes what is faint, far, giant or loose, and nothing else", "[scan.splats]")
{
    Splats statue = splat_scenes::statue();
    add(statue, {0, 0, 0.4}, {0, 0, 1}, 0.1, 0.6);  // As large and opaque as a plain wall.
    Splats splats;
    add(splats, {0, 0, 0.1}, {0, 0, 1}, 0.01, 0.019);
    for (std::size_t i = 0; i < statue.size(); ++i)
        splats::samples::copy(statue, i, splats);
    add(splats, {0, 0, 50}, {0, 0, 1}, 0.01);
    add(splats, {0, 0, -50}, {0, 0, 1}, 0.01);
    add(splats, {0, 0, 0.3}, {0, 0, 1}, 0.5);
    add(splats, {0, 0, 0.3}, {0, 0, 1}, 0.1, 0.4);
    for (int i = 0; i < 3; ++i)
        add(splats, {0.2, 0.2, 0.5 + 0.001 * i}, {0, 0, 1}, 0.002);
    const CleanedSplats clean = cleaned(splats);
    CHECK(clean.faint == 1);
    CHECK(clean.far == 2);
    CHECK(clean.giant == 2);
    CHECK(clean.loose == 3);
    CHECK(clean.needle_share == 0);
    CHECK(clean.splats.centers == statue.centers);
    CHECK(clean.splats.rotations == statue.rotations);
    CHECK(clean.splats.scales == statue.scales);
    CHECK(clean.splats.opacities == statue.opacities);
    CHECK(clean.splats.colors == statue.colors);
}

TEST_CASE("parts whose cells touch are one heap, and a second object of some size stays", "[scan.splats]")
{
    Splats splats;
    rectangle(splats, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.02);
    rectangle(splats, {1.2, 0, 0.2}, {0.2, 0, 0}, {0, 0.2, 0}, 0.02);
    rectangle(splats, {-0.2, 0, 0.2}, {0.04, 0, 0}, {0, 0.04, 0}, 0.02);
    const CleanedSplats clean = cleaned(splats);
    CHECK(clean.loose == 4);
    CHECK(clean.splats.size() == 2600);
}

TEST_CASE("the share of streaks is that of opacity times footprint", "[scan.splats]")
{
    Splats splats;
    rectangle(splats, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.02);
    const std::size_t round = splats.size();
    rectangle(splats, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.02);
    for (std::size_t i = round; i < splats.size(); ++i)
        splats.scales[i] = {splats.scales[i].x * 6, splats.scales[i].x / 2, 0.0001F};
    CHECK(cleaned(splats).needle_share == Approx(0.75));
    // The needles, 72 mm long, are three quarters; nine of ten centers lie within 0.556 m of the median of the square.
    CHECK(cleaned(splats).coarseness == Approx(0.072 / 0.556).margin(0.002));
    CHECK(cleaned(Splats{}).splats.size() == 0);
}
