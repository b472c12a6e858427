#include "catch.h"

#include <fresco/error.h>
#include <fresco/value.h>

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
    CHECK_THROWS_WITH(fresco::parse_json("{\"a\": 1, \"b\": 2, \"a\": 3}", "f.json"),
                      "f.json: not valid JSON: the key \"a\" appears twice");
    CHECK_THROWS_WITH(fresco::parse_json("{\"a: b\": [[N", "f.json"),
                      "f.json: not valid JSON at byte 12: invalid literal; last read: '\"a: b\": [[N'");
    CHECK_THROWS_WITH(fresco::parse_json("{\"a\": }", "f.json"), Contains("byte 7"));
    CHECK_THROWS_WITH(fresco::parse_json(std::string(100, '[') + std::string(100, ']')), Contains("64 levels"));
    CHECK_THROWS_AS(fresco::parse_json(""), fresco::Error);
    CHECK_THROWS_AS(fresco::parse_json("1 2"), fresco::Error);
    CHECK_THROWS_WITH(fresco::parse_json(std::string_view("{}\0}", 4), "f.json"), Contains("byte 3"));
    CHECK_THROWS_AS(fresco::to_json(Value(std::numeric_limits<double>::quiet_NaN())), fresco::Error);
}

TEST_CASE("A value of another kind is named in the error")
{
    CHECK_THROWS_WITH(Value("x").as_int(), Contains("whole number") && Contains("\"x\""));
    CHECK_THROWS_WITH(Value(Value::Map{}).at("faces"), Contains("faces"));
    CHECK(Value(3).as_double() == 3.0);
}

TEST_CASE("A place in a JSON file gives what it has, and names where something is missing, unknown or of another kind")
{
    const Value value = fresco::parse_json(R"({"a": 1, "b": [{"c": "x"}, {"d": [1, 2.5]}], "w": 640.0})");
    const fresco::JsonPlace whole(value, "f.json");
    CHECK(whole["a"].integer(0, 1) == 1);
    CHECK(whole["w"].size() == 640);
    CHECK(whole["b"].list(2)[1]["d"].numbers(2) == std::vector<double>{1, 2.5});
    CHECK_FALSE(whole.find("x"));
    CHECK_NOTHROW(whole.has_only({"a", "b", "w"}));
    CHECK_THROWS_WITH(whole.has_only({"a", "b"}), "f.json: unknown entry 'w'");
    CHECK_THROWS_WITH(whole["x"], "f.json: x: missing");
    CHECK_THROWS_WITH(whole["b"].list()[0]["d"], "f.json: b[0].d: missing");
    CHECK_THROWS_WITH(whole["b"].list()[1]["d"].list()[1].integer(), "f.json: b[1].d[1]: expected an integer, got 2.5");
    CHECK_THROWS_WITH(whole["a"].integer(2, 3), "f.json: a: expected an integer from 2 to 3, got 1");
    CHECK_THROWS_WITH(whole["b"].text(), "f.json: b: expected a text, got a list");
    CHECK_THROWS_WITH(whole["b"].list(3), Contains("f.json: b: ") && Contains("3"));
    CHECK_THROWS_WITH(whole["a"]["c"], Contains("f.json: a: expected a map"));
    const Value own = fresco::parse_json(R"({"a": 2})");
    const fresco::JsonPlace frame(own, value, "f.json: frame 3");
    CHECK(frame["a"].integer() == 2);
    CHECK_THROWS_WITH(frame["w"].flag(), Contains("f.json: frame 3: w: "));
}
