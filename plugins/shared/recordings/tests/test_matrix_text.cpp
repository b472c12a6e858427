#include "catch.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <cmath>

using Catch::Contains;

TEST_CASE("a matrix is read row by row, with blanks, tabs, carriage returns and exponents", "[matrix_text]")
{
    const auto m = fresco::recordings::parse_matrix_text("1 \t-2.5\r\n\n +3e1  4e-2\n", 2, 2, "m.txt");
    CHECK(m == std::vector<double>{1, -2.5, 30, 0.04});
    CHECK(std::isinf(fresco::recordings::parse_matrix_text("-inf", 1, 1, "m.txt")[0]));
    CHECK(std::isnan(fresco::recordings::parse_matrix_text("nan", 1, 1, "m.txt")[0]));
}

TEST_CASE("errors of a matrix name the line", "[matrix_text]")
{
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 2\n3 x4\n", 2, 2, "m.txt"),
                      Contains("m.txt:2: \"x4\" is not a number"));
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 2\n3,5 4\n", 2, 2, "m.txt"), Contains("m.txt:2: \"3,5\""));
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 +-2\n", 1, 2, "m.txt"), Contains("\"+-2\""));
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 2\n3\n", 2, 2, "m.txt"), Contains("m.txt:2: 1 numbers"));
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 2\n3 4\n\n5 6\n", 2, 2, "m.txt"),
                      Contains("m.txt:4: ") && Contains("another row"));
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 2\n", 2, 2, "m.txt"), Contains("1 rows; expected a 2x2"));
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1e999", 1, 1, "m.txt"), Contains("range"));
    CHECK_THROWS_AS(fresco::recordings::read_matrix_text("/nowhere/m.txt", 1, 1), fresco::MissingInput);
    CHECK_THROWS_WITH(fresco::recordings::parse_numbers("1 2 3", 4, "list"), Contains("3 numbers; expected 4"));
}

TEST_CASE("a rigid transform is rotation and translation, anything else is refused", "[matrix_text]")
{
    const auto t = fresco::recordings::rigid_transform({0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1}, "p");
    CHECK(t.point({1, 0, 0}) == fresco::Vec3d{5, 7, 7});
    // Turned by 30 degrees, written with three digits.
    const auto rounded = fresco::recordings::rigid_transform({0.866, -0.5, 0, 0, 0.5, 0.866, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "p");
    CHECK(rounded.rotation_error() < 1e-14);
    CHECK(rounded.rotation(0, 0) == Approx(std::cos(std::atan2(0.5, 0.866))).epsilon(1e-12));
    CHECK_THROWS_WITH(fresco::recordings::rigid_transform({NAN, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "p"),
                      Contains("not finite"));
    CHECK_THROWS_WITH(fresco::recordings::rigid_transform({-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "p"),
                      Contains("not a rotation"));
    CHECK_THROWS_WITH(fresco::recordings::rigid_transform({-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "p"),
                      Contains("(it mirrors)"));
    CHECK_THROWS_WITH(fresco::recordings::rigid_transform({2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}, "p"),
                      Contains("not a rotation (it is off by 3.0)"));
    CHECK_THROWS_WITH(fresco::recordings::rigid_transform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1}, "p"),
                      Contains("0 0 0 1"));
    CHECK_THROWS_WITH(fresco::recordings::rigid_transform({1, 0, 0}, "p"), Contains("4x4"));
}

TEST_CASE("intrinsics of 3x3 and 4x4 matrices, with both conventions of the pixel center", "[matrix_text]")
{
    const std::vector<double> small{500, 0, 319.5, 0, 510, 239.5, 0, 0, 1};
    const std::vector<double> large{500, 0, 319.5, 0, 0, 510, 239.5, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const fresco::Intrinsics centerd{640, 480, 500, 510, 320, 240};
    CHECK(fresco::recordings::intrinsics_from_matrix(small, fresco::recordings::PixelCenter::integer, 640, 480, "k") == centerd);
    CHECK(fresco::recordings::intrinsics_from_matrix(large, fresco::recordings::PixelCenter::integer, 640, 480, "k") == centerd);
    CHECK(fresco::recordings::intrinsics_from_matrix(small, fresco::recordings::PixelCenter::half, 640, 480, "k").cx == 319.5);
    auto skewed = small;
    skewed[1] = 0.5;
    CHECK_THROWS_WITH(fresco::recordings::intrinsics_from_matrix(skewed, fresco::recordings::PixelCenter::half, 640, 480, "k"),
                      Contains("row 1, column 2"));
    auto negative = small;
    negative[4] = -510;
    CHECK_THROWS_WITH(fresco::recordings::intrinsics_from_matrix(negative, fresco::recordings::PixelCenter::half, 640, 480, "k"),
                      Contains("positive"));
    auto broken = small;
    broken[0] = INFINITY;
    CHECK_THROWS_WITH(fresco::recordings::intrinsics_from_matrix(broken, fresco::recordings::PixelCenter::half, 640, 480, "k"),
                      Contains("finite"));
}
