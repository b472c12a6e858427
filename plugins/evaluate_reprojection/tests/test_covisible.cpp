#include "catch.h"
#include "covisible.h"
#include "wall_scene.h"

#include <cmath>

using namespace fresco;
using namespace wall_scene;

namespace
{
double target_x(const Match& match)
{
    return match.target.x0 + match.target.share_x;
}
double target_y(const Match& match)
{
    return match.target.y0 + match.target.share_y;
}
}  // namespace

TEST_CASE("equal cameras match every pixel with itself, exactly")
{
    Camera c = camera(40, 30, 7, -3);
    const ViewSurface view = surface(c);
    const auto matches = covisible(view, view, Protocol::paper);
    REQUIRE(matches.size() == 40 * 30);
    for (const Match& match : matches)
    {
        CHECK(target_x(match) == match.x);
        CHECK(target_y(match) == match.y);
        CHECK(match.target.x1 == match.target.x0);
    }
}

TEST_CASE("a camera that moves by pixels finds points that many pixels back")
{
    const ViewSurface source = surface(camera(40, 30, 0, 0));
    const auto matches = covisible(source, surface(camera(40, 30, 3, 0.25)), Protocol::paper);
    CHECK(matches.size() == 37 * 29);  // three columns leave, and the first row lies above the first centers
    for (const Match& match : matches)
    {
        CHECK(target_x(match) == Approx(match.x - 3));
        CHECK(target_y(match) == Approx(match.y - 0.25));
        CHECK(match.target.y1 == match.target.y0 + 1);
    }
    // Twice as near: half of the picture, every other pixel of the target.
    const auto nearer = covisible(source, surface(camera(40, 30, 0, 0, 1)), Protocol::paper);
    for (const Match& match : nearer)
        CHECK(target_x(match) == Approx(2 * (match.x + 0.5 - 20) + 20 - 0.5));
    CHECK(nearer.size() == 20 * 14);  // half a row more on either side would lie beyond the outermost centers
}

TEST_CASE("a point is seen where the target's depth agrees within 2 % and 1 cm, or 0.1 m as released")
{
    const ViewSurface source = surface(camera(20, 20, 0, 0));
    const auto count = [&](float depth, Protocol protocol)
    {
        ViewSurface target = source;
        for (float& d : target.depth.values)
            d = depth;
        return covisible(source, target, protocol).size();
    };
    CHECK(count(2.049F, Protocol::paper) == 400);
    CHECK(count(2.051F, Protocol::paper) == 0);
    CHECK(count(1.949F, Protocol::paper) == 0);
    CHECK(count(2.099F, Protocol::released) == 19 * 19);  // not in the last column and row
    CHECK(count(2.101F, Protocol::released) == 0);
}

TEST_CASE("all pixels that contribute must agree")
{
    const ViewSurface source = surface(camera(20, 20, 0, 0));
    ViewSurface target = surface(camera(20, 20, 0.5, 0));
    target.depth.at(10, 10) = 1.5F;  // something stands before the wall
    const auto matches = covisible(source, target, Protocol::paper);
    CHECK(matches.size() == 19 * 20 - 2);
    for (const Match& match : matches)
        CHECK_FALSE((match.y == 10 && (match.x == 10 || match.x == 11)));
}

TEST_CASE("pixels beside a hole are left out in both pictures, as released only the hole")
{
    const ViewSurface whole = surface(camera(20, 20, 0, 0));
    ViewSurface holed = whole;
    holed.depth.at(10, 10) = 0;
    find_inner_pixels(holed);
    CHECK(covisible(holed, whole, Protocol::paper).size() == 400 - 9);
    CHECK(covisible(whole, holed, Protocol::paper).size() == 400 - 9);
    CHECK(covisible(holed, whole, Protocol::released).size() == 19 * 19 - 1);
}

TEST_CASE("the released lookup is displaced by x / W pixels")
{
    const ViewSurface view = surface(camera(40, 30, 0, 0));
    const auto matches = covisible(view, view, Protocol::released);
    REQUIRE(matches.size() == 39 * 29);
    for (const Match& match : matches)
    {
        CHECK(target_x(match) == Approx(match.x - match.x / 40.0));
        CHECK(target_y(match) == Approx(match.y - match.y / 30.0));
    }
}

TEST_CASE("surface behind the target's camera is not seen")
{
    const ViewSurface source = surface(camera(20, 20, 0, 0));
    ViewSurface target = source;
    target.camera.world_from_camera.translation = {0, 0, 3};
    CHECK(covisible(source, target, Protocol::paper).empty());
    CHECK(covisible(source, target, Protocol::released).empty());
}
