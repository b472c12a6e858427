#include "catch.h"
#include "pipeline/yaml_document.h"

#include <fmt/ranges.h>

using namespace fresco::host;

namespace
{

struct Parsed
{
    YamlNode root;
    std::vector<std::string> problems;
    bool complete = false;
};

Parsed parse(const std::string& text)
{
    Parsed parsed;
    ProblemList problems;
    const auto source = std::make_shared<const YamlSource>(YamlSource{"f.yaml", "/folder", false});
    parsed.root = parse_yaml(text, source, problems, parsed.complete);
    for (const Problem& problem : problems.sorted())
        parsed.problems.push_back(to_string(problem));
    return parsed;
}

/// All problems of a text, joined.
std::string yaml_problem(const std::string& text)
{
    return fmt::format("{}", fmt::join(parse(text).problems, " | "));
}

ResolvedScalar resolve(const std::string& text, bool plain = true)
{
    YamlNode node(YamlNode::Kind::scalar);
    node.text = text;
    node.plain = plain;
    return resolve_scalar(node);
}

std::string repeated(const std::string& text, std::size_t count)
{
    return fmt::format("{}", fmt::join(std::vector(count, text), ""));
}

}  // namespace

TEST_CASE("A document keeps its order, its quotes and its places; columns count characters", "[yaml]")
{
    const Parsed parsed = parse("b: 1\na:\n  - x\n  - 'y'\nc: {ä: é, d: \"it's\"}\ne:\n\nf: ~\n");
    REQUIRE(parsed.problems.empty());
    REQUIRE(parsed.complete);
    const auto place_of = [](const YamlNode& node) { return std::pair(node.line, node.column); };
    const YamlNode& y = parsed.root.find("a")->value.items.at(1);
    CHECK(y.text == "y");
    CHECK_FALSE(y.plain);
    CHECK(place_of(y) == std::pair(4, 5));
    CHECK(parsed.root.find("c")->value.find("d")->value.text == "it's");
    CHECK(place_of(parsed.root.find("c")->value.find("d")->value) == std::pair(5, 14));
    // A missing value stands where its key is.
    CHECK(parsed.root.find("e")->value.is_null());
    CHECK(place_of(parsed.root.find("e")->value) == std::pair(6, 1));
    CHECK(parsed.root.find("f")->value.is_null());
    CHECK(parse("\xEF\xBB\xBF%YAML 1.2\n---\na: 'it''s'\n...\n").root.find("a")->value.text == "it's");
}

TEST_CASE("What a pipeline file must not hold is named with its place", "[yaml]")
{
    for (const auto& [text, place, word] : std::vector<std::array<std::string, 3>>{
             {"a: &a [*a]\n", "1:4", "anchors (&a)"},
             {"a: &a [*a]\n", "1:4", "f.yaml:1:8: error: aliases"},
             {"x: &n\ny: 1\n", "1:4", "anchors (&n)"},
             {"a: {b: 1}\n<<: {c: 2}\n", "2:1", "merge keys"},
             {"a: 1\nb: 2\na: 3\n", "3:1", "the key 'a' appears twice; the first is on line 1"},
             {"a: 1\n---\nb: 2\n", "2:1", "a second document"},
             {"a: 1\n...\nb\n", "3:1", "after the end"},
             {"{a: 1} b\n", "1:8", "after the end"},
             {"a: ! 1\n", "1:4", "tags (!)"},
             {"a: !mine {b: 1}\n", "1:4", "tags (!mine)"},
             {"[a, b]: 1\n", "1:1", "a key must be a word, not a list"},
             {"a:\n\tb: 1\n", "2:1", "a tab"},
             {"a: b: c\n", "1:5", "a second ':'"},
             {"a: [1, 2\n", "", "a '[' is not closed"},
             {"a: {b: ${x}/c}\n", "", "needs quotes"},
             {"a: \"never \\\"\n", "1:4", "quote"},
             {"a: \xff\n", "1:4", "UTF-8"},
             {std::string("a: \0b\n", 6), "1:4", "UTF-8"},
             {"a: [\"p.yaml\\0.ply\"]\n", "1:5", "control character"},
             {"a: \"\\u009b2J\"\n", "1:4", "control character"},
             {"run: [echo, \"shown\\rhidden\"]\n", "1:13", "control character"},
             {"a: \xc2\x9b\n", "1:4", "control character"},
             {"\"a\\x7f\": 1\n", "1:1", "control character"},
             {"\"a\\tb\": 1\n", "1:1", "an end of line or a tab"}})
    {
        CAPTURE(text);
        CHECK_THAT(yaml_problem(text), StartsWith("f.yaml:" + place) && Contains("error: ") && Contains(word));
    }
}

TEST_CASE("Documents beyond the limits are refused", "[yaml]")
{
    CHECK_THAT(yaml_problem(repeated("{a:\n", 100'000)), Contains("nested deeper than 32"));
    CHECK_THAT(yaml_problem(repeated("- ", 30'000)), Contains("nested deeper than 32"));
    CHECK_THAT(yaml_problem("a: [" + repeated("1,\n", 120'000) + "1]"), Contains("more than 100000 values"));
    CHECK_THAT(yaml_problem("a: 1\nb: [" + repeated("1,", 40'000) + "1]"), StartsWith("f.yaml:2:1: error: a line of more than"));
    const auto nested = [](std::size_t depth) { return yaml_problem(repeated("[", depth) + repeated("]", depth)); };
    CHECK(nested(yaml_depth_limit) == "");
    CHECK_THAT(nested(yaml_depth_limit + 1), Contains("nested deeper"));
}

TEST_CASE("Plain words mean what the core schema of YAML 1.2 says", "[yaml]")
{
    using fresco::Value;
    for (const auto& [text, value] : std::map<std::string, Value>{{"true", true},
                                                                  {"FALSE", false},
                                                                  {"~", Value()},
                                                                  {"-12", -12},
                                                                  {"+12", 12},
                                                                  {"0", 0},
                                                                  {"1e-4", 1e-4},
                                                                  {"1E3", 1000.0},
                                                                  {"-.5", -0.5},
                                                                  {"1.", 1.0},
                                                                  {"9223372036854775807", std::int64_t{9223372036854775807}}})
        CHECK(resolve(text).value == value);
    CHECK(resolve("-9223372036854775808").value.is_int());
    for (const char* text :
         {"yes", "on", "No", "1,5", "1_000", "1.2.3", "-", "+", ".", "e5", "nan", "inf", "0x", "2020-01-01", "1e", "--1"})
    {
        CHECK(resolve(text).value == Value(text));
        CHECK(resolve(text).refusal.empty());
    }
    for (const char* text : {"010", "-010", "0x1f", "0o17", ".nan", "-.inf", "1e999", "9223372036854775808"})
    {
        CHECK_FALSE(resolve(text).refusal.empty());
        CHECK(resolve(text, false).value == Value(text));
    }
}
