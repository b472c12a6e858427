#include "catch.h"

#include <fresco/error.h>
#include <fresco/strict_map.h>
#include <fresco/value.h>

#include <ctime>
#include <limits>

using fresco::Value;

TEST_CASE("JSON reads back what was written, kinds and order included")
{
    const Value value = Value::Map{{"z", 1},
                                   {"a", 2.0},
                                   {"tiny", 1e-300},
                                   {"large", std::numeric_limits<std::int64_t>::max()},
                                   {"text", "tab\t quote\" umlaut \xc3\xa4"},
                                   {"list", Value::List{true, Value{}, Value::Map{}}},
                                   {"empty", Value::List{}}};
    CHECK(fresco::parse_json(fresco::to_json(value)) == value);
    CHECK(fresco::parse_json(fresco::to_json(value, 2)) == value);
    CHECK(fresco::to_json(Value(0.1)) == "0.1");
    CHECK(fresco::to_json(Value(3.0)) == "3.0");
}

TEST_CASE("Bad JSON is refused with the byte")
{
    using Catch::Contains;
    CHECK_THROWS_WITH(fresco::parse_json("{\"a\": 1, \"a\": 2}", "f.json"), Contains("f.json") && Contains("twice"));
    CHECK_THROWS_WITH(fresco::parse_json("{\"a\": }", "f.json"), Contains("byte 7"));
    CHECK_THROWS_WITH(fresco::parse_json(std::string(100, '[') + std::string(100, ']')), Contains("64 levels"));
    CHECK_THROWS_AS(fresco::parse_json(""), fresco::Error);
    CHECK_THROWS_AS(fresco::parse_json("1 2"), fresco::Error);
    CHECK_THROWS_WITH(fresco::parse_json(std::string_view("{}\0}", 4), "f.json"), Contains("byte 3"));
    CHECK_THROWS_AS(fresco::to_json(Value(std::numeric_limits<double>::quiet_NaN())), fresco::Error);
}

TEST_CASE("A JSON map of many keys is read in time, and a key that appears twice is found among them")
{
    std::string text = "{";
    for (int i = 0; i < 300'000; ++i)
        text += "\"" + std::to_string(i) + "\":0,";
    const std::clock_t begin = std::clock();
    CHECK(fresco::parse_json(text + "\"a\":0}").as_map().size() == 300'001);
    CHECK_THROWS_WITH(fresco::parse_json("{\"a: b\": [[N", "f.json"),
                      "f.json: not valid JSON at byte 12: invalid literal; last read: '\"a: b\": [[N'");
    CHECK_THROWS_WITH(fresco::parse_json(text + "\"7\":0}", "f.json"), "f.json: not valid JSON: the key \"7\" appears twice");
    CHECK(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC < 30);
}

TEST_CASE("A value of another kind is named in the error")
{
    using Catch::Contains;
    CHECK_THROWS_WITH(Value("x").as_int(), Contains("whole number") && Contains("\"x\""));
    CHECK_THROWS_WITH(Value(Value::Map{}).at("faces"), Contains("faces"));
    CHECK(Value(3).as_double() == 3.0);
}

TEST_CASE("A strict map gives what it has, and names what is missing or not known")
{
    const fresco::Value value = fresco::parse_json(R"({"a": 1, "b": 2})");
    fresco::StrictMap map(value);
    CHECK(map.take("a").as_int() == 1);
    CHECK_THROWS_WITH(map.take("c"), "the entry \"c\" is missing");
    CHECK_THROWS_WITH(map.refuse_others(), "the entry \"b\" is not known");
    map.take("b");
    CHECK_NOTHROW(map.refuse_others());
    const fresco::Value list{fresco::Value::List{}};
    CHECK_THROWS_WITH(fresco::StrictMap(list).take("a"), "the entry \"a\" is missing");
}
