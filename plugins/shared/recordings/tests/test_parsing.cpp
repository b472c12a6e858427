#include "catch.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <cmath>

using namespace fresco::recordings;

TEST_CASE("numbers are whole words, finite and within their range", "[recordings]")
{
    CHECK(number_of("-2.5e3", "x") == -2500);
    for (const char* word : {"", "1,5", "nan", "inf", "1e999", "0x10", "3a", "+"})
        CHECK_THROWS_WITH(number_of(word, "f:3"), Contains("f:3: \"" + std::string(word) + "\": expected a finite number"));
    CHECK(integer_of("12", 0, 12, "x") == 12);
    for (const char* word : {"13", "-1", "1.0", "", "99999999999999999999"})
        CHECK_THROWS_WITH(integer_of(word, 0, 12, "f:3"), Contains("f:3: ") && Contains("from 0 to 12"));
}

TEST_CASE("a rigid transform is rotation and translation, anything else is refused", "[matrix_text]")
{
    const auto t = rigid_transform({0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1}, "p");
    CHECK(t.point({1, 0, 0}) == fresco::Vec3d{5, 7, 7});
    // Turned by 30 degrees, written with three digits.
    const auto rounded = rigid_transform({0.866, -0.5, 0, 0, 0.5, 0.866, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "p");
    CHECK(rounded.rotation_error() < 1e-14);
    CHECK(rounded.rotation(0, 0) == Approx(std::cos(std::atan2(0.5, 0.866))).epsilon(1e-12));
    CHECK_THROWS_WITH(rigid_transform({-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "p"), Contains("not a rotation"));
    CHECK_THROWS_WITH(rigid_transform({-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "p"), Contains("(it mirrors)"));
    CHECK_THROWS_WITH(rigid_transform({2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}, "p"),
                      Contains("not a rotation (it is off by 3.0)"));
    CHECK_THROWS_WITH(rigid_transform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1}, "p"), Contains("0 0 0 1"));
    CHECK_THROWS_WITH(rigid_transform({1, 0, 0}, "p"), Contains("4x4"));
}

TEST_CASE("intrinsics of 3x3 and 4x4 matrices, with both conventions of the pixel center", "[matrix_text]")
{
    const std::vector<double> small{500, 0, 319.5, 0, 510, 239.5, 0, 0, 1};
    const std::vector<double> large{500, 0, 319.5, 0, 0, 510, 239.5, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const fresco::Intrinsics centerd{640, 480, 500, 510, 320, 240};
    CHECK(intrinsics_from_matrix(small, PixelCenter::integer, 640, 480, "k") == centerd);
    CHECK(intrinsics_from_matrix(large, PixelCenter::integer, 640, 480, "k") == centerd);
    CHECK(intrinsics_from_matrix(small, PixelCenter::half, 640, 480, "k").cx == 319.5);
    auto skewed = small;
    skewed[1] = 0.5;
    CHECK_THROWS_WITH(intrinsics_from_matrix(skewed, PixelCenter::half, 640, 480, "k"), Contains("row 1, column 2"));
    auto negative = small;
    negative[4] = -510;
    CHECK_THROWS_WITH(intrinsics_from_matrix(negative, PixelCenter::half, 640, 480, "k"), Contains("positive"));
}
