#include "catch.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <cmath>

using Catch::Contains;
using namespace fresco::recordings;

TEST_CASE("lines are walked with their numbers, comments and blank lines passed over", "[recordings]")
{
    LineReader lines("# head\r\n\n  \t\nfirst 1\r\n #x\nsecond\t2\n", "list.txt");
    CHECK(lines.next_record() == "first 1");
    CHECK(lines.place() == "list.txt:4");
    CHECK(lines.next() == " #x");
    CHECK(words_of(*lines.next()) == std::vector<std::string_view>{"second", "2"});
    CHECK(lines.place() == "list.txt:6");
    CHECK_FALSE(lines.next_record());
    CHECK_FALSE(lines.next());
    CHECK_THROWS_WITH(LineReader("a\nb", "list.txt"), Contains("list.txt: the last line has no newline"));
    CHECK_THROWS_AS(LineReader("", "list.txt"), fresco::Error);
    CHECK(words_of("").empty());
    CHECK(words_of(" 1, 2,,3", ",") == std::vector<std::string_view>{" 1", " 2", "3"});
}

TEST_CASE("numbers are whole words, finite and within their range", "[recordings]")
{
    CHECK(number_of("-2.5e3", "x") == -2500);
    for (const char* word : {"", "1,5", "nan", "inf", "1e999", "0x10", "3a", "+"})
        CHECK_THROWS_WITH(number_of(word, "f:3"), Contains("f:3: \"" + std::string(word) + "\": expected a finite number"));
    CHECK(integer_of("12", 0, 12, "x") == 12);
    for (const char* word : {"13", "-1", "1.0", "", "99999999999999999999"})
        CHECK_THROWS_WITH(integer_of(word, 0, 12, "f:3"), Contains("f:3: ") && Contains("from 0 to 12"));
}

TEST_CASE("a quaternion turns as it should", "[recordings]")
{
    const double h = std::sqrt(0.5);
    // A quarter turn about z takes x to y.
    const auto turn = quaternion_transform(h, 0, 0, h, {1, 2, 3}, "x");
    const auto p = turn.point({1, 0, 0});
    CHECK(p.x == Approx(1));
    CHECK(p.y == Approx(3));
    CHECK(p.z == Approx(3));
    // About x it takes y to z, about y it takes z to x.
    CHECK(quaternion_transform(h, h, 0, 0, {}, "x").direction({0, 1, 0}).z == Approx(1));
    CHECK(quaternion_transform(h, 0, h, 0, {}, "x").direction({0, 0, 1}).x == Approx(1));
    CHECK(quaternion_transform(1.005, 0, 0, 0, {}, "x").rotation == fresco::Mat3{});
    CHECK_THROWS_AS(quaternion_transform(NAN, 1, 0, 0, {}, "f:2"), fresco::Error);
}

TEST_CASE("names go by the numbers in them", "[recordings]")
{
    std::vector<std::string> names{"frame10", "frame9", "b", "frame2b", "frame", "frame02", "frame2", "frame2a", ""};
    std::sort(names.begin(), names.end(), natural_less);
    CHECK(names == std::vector<std::string>{"", "b", "frame", "frame02", "frame2", "frame2a", "frame2b", "frame9", "frame10"});
    for (const auto& a : names)
        for (const auto& b : names)
            CHECK((natural_less(a, b) ? 1 : 0) + (natural_less(b, a) ? 1 : 0) == (a == b ? 0 : 1));
    CHECK(number_after("seq-01", "seq-") == 1);
    CHECK(number_after("10", "") == 10);
    for (const char* text : {"seq-", "seq--1", "seq-1b", "sea-1", "seq-1234567890123456789"})
        CHECK_FALSE(number_after(text, "seq-"));
    CHECK(last_number("seq2-frame0012.x") == 12);
    CHECK(last_number("7") == 7);
    CHECK_FALSE(last_number("none"));
    CHECK_FALSE(last_number(""));
    CHECK_FALSE(last_number("1234567890123456789"));
}

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
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 2\n3\n", 2, 2, "m.txt"), Contains("m.txt:2: 1 numbers"));
    CHECK_THROWS_WITH(fresco::recordings::parse_matrix_text("1 2\n3 4\n\n5 6\n", 2, 2, "m.txt"),
                      Contains("m.txt:4: ") && Contains("another row"));
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
}
