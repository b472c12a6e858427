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
    CHECK_THROWS_WITH(quaternion_transform(1, 1, 0, 0, {}, "f:2"), Contains("f:2: ") && Contains("its length is 1.4142"));
    CHECK_THROWS_AS(quaternion_transform(NAN, 1, 0, 0, {}, "f:2"), fresco::Error);
    CHECK_THROWS_AS(quaternion_transform(1, 0, 0, 0, {NAN, 0, 0}, "f:2"), fresco::Error);
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
