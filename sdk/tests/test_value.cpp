#include <fresco/error.h>
#include <fresco/value.h>

#include <catch2/catch.hpp>

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
    using Catch::Matchers::Contains;
    CHECK_THROWS_WITH(fresco::parse_json("{\"a\": 1, \"a\": 2}", "f.json"), Contains("f.json") && Contains("twice"));
    CHECK_THROWS_WITH(fresco::parse_json("{\"a\": }", "f.json"), Contains("byte 7"));
    CHECK_THROWS_WITH(fresco::parse_json(std::string(100, '[') + std::string(100, ']')), Contains("64 levels"));
    CHECK_THROWS_AS(fresco::parse_json(""), fresco::Error);
    CHECK_THROWS_AS(fresco::parse_json("1 2"), fresco::Error);
    CHECK_THROWS_AS(fresco::to_json(Value(std::numeric_limits<double>::quiet_NaN())), fresco::Error);
}

TEST_CASE("A value of another kind is named in the error")
{
    using Catch::Matchers::Contains;
    CHECK_THROWS_WITH(Value("x").as_int(), Contains("whole number") && Contains("\"x\""));
    CHECK_THROWS_WITH(Value(Value::Map{}).at("faces"), Contains("faces"));
    CHECK(Value(3).as_double() == 3.0);
}
