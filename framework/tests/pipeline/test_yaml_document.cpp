#include "catch.h"
#include "pipeline/yaml_document.h"

#include <chrono>

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

/// The only problem of a text, or all of them joined where there is not one.
std::string yaml_problem(const std::string& text)
{
    std::string joined;
    for (const std::string& problem : parse(text).problems)
        joined += (joined.empty() ? "" : " | ") + problem;
    return joined;
}

ResolvedScalar resolve(const std::string& text, bool plain = true)
{
    YamlNode node;
    node.kind = YamlNode::Kind::scalar;
    node.text = text;
    node.plain = plain;
    return resolve_scalar(node);
}
}  // namespace

TEST_CASE("A document keeps its order, its quotes and its places", "[yaml]")
{
    const Parsed parsed = parse("b: 1\na:\n  - x\n  - 'y'\nc: {d: \"z\"}\n");
    REQUIRE(parsed.problems.empty());
    REQUIRE(parsed.complete);
    REQUIRE(parsed.root.entries.size() == 3);
    CHECK(parsed.root.entries[0].key == "b");
    CHECK(parsed.root.entries[0].value.plain);
    const YamlNode& list = parsed.root.entries[1].value;
    REQUIRE(list.items.size() == 2);
    CHECK(list.items[1].text == "y");
    CHECK_FALSE(list.items[1].plain);
    CHECK(list.items[1].line == 4);
    CHECK(list.items[1].column == 5);
    CHECK(parsed.root.find("c")->value.find("d")->value.column == 8);
    CHECK(parsed.root.find("a")->line == 2);
}

TEST_CASE("Columns count characters", "[yaml]")
{
    const Parsed parsed = parse("{ä: é, b: x}\n");
    REQUIRE(parsed.problems.empty());
    CHECK(parsed.root.find("b")->column == 8);
}

TEST_CASE("A value that is missing stands where its key is", "[yaml]")
{
    const Parsed parsed = parse("a:\n\n\nb: 1\nc: ~\n");
    REQUIRE(parsed.root.find("a")->value.is_null());
    CHECK(parsed.root.find("a")->value.line == 1);
    CHECK(parsed.root.find("a")->value.column == 1);
    CHECK(parsed.root.find("c")->value.is_null());
}

TEST_CASE("What a pipeline file must not hold is named with its place", "[yaml]")
{
    using Catch::Contains;
    using Catch::StartsWith;
    CHECK_THAT(yaml_problem("a: &a [*a]\n"),
               StartsWith("f.yaml:1:4: error: anchors (&a)") && Contains("f.yaml:1:8: error: aliases (*name)"));
    CHECK_THAT(yaml_problem("x: &n\ny: 1\n"), StartsWith("f.yaml:1:4: error: anchors (&n)"));
    CHECK_THAT(yaml_problem("a: {b: 1}\n<<: {c: 2}\n"), StartsWith("f.yaml:2:1: error: merge keys (<<)"));
    CHECK_THAT(yaml_problem("a: 1\nb: 2\na: 3\n"),
               StartsWith("f.yaml:3:1: error: the key 'a' appears twice; the first is on line 1"));
    CHECK_THAT(yaml_problem("a: 1\n---\nb: 2\n"), StartsWith("f.yaml:2:1: error: a second document"));
    CHECK_THAT(yaml_problem("a: 1\n...\nb\n"), StartsWith("f.yaml:3:1: error: there is text after the end"));
    CHECK_THAT(yaml_problem("{a: 1} b\n"), StartsWith("f.yaml:1:8: error: there is text after the end"));
    CHECK_THAT(yaml_problem("{a: 1} ]\n"), Contains("f.yaml:1:8: error:"));
    CHECK_THAT(yaml_problem("a: !!str 1\n"), StartsWith("f.yaml:1:4: error: tags ("));
    CHECK_THAT(yaml_problem("a: ! 1\n"), StartsWith("f.yaml:1:4: error: tags (!)"));
    CHECK_THAT(yaml_problem("a: !mine {b: 1}\n"), StartsWith("f.yaml:1:4: error: tags (!mine)"));
    CHECK_THAT(yaml_problem("[a, b]: 1\n"), StartsWith("f.yaml:1:1: error: a key must be a word, not a list"));
    CHECK_THAT(yaml_problem("a:\n\tb: 1\n"), StartsWith("f.yaml:2:1: error: a tab cannot indent"));
    CHECK_THAT(yaml_problem("a: b: c\n"), StartsWith("f.yaml:1:5: error: a second ':'"));
    CHECK_THAT(yaml_problem("a: [1, 2\n"), Contains("error: a '[' is not closed"));
    CHECK_THAT(yaml_problem("a: {b: ${x}/c}\n"), Contains("needs quotes"));
    CHECK_THAT(yaml_problem("a: 'never closed\nb: 2\n"), StartsWith("f.yaml:1:4: error: this quote is never closed"));
    CHECK_THAT(yaml_problem("a: \"never \\\"\n"), StartsWith("f.yaml:1:4: error: this quote is never closed"));
    CHECK_THAT(yaml_problem("a: \xff\n"), StartsWith("f.yaml:1:4: error: invalid UTF-8"));
    CHECK_THAT(yaml_problem(std::string("a: \0b\n", 6)), StartsWith("f.yaml:1:4: error: invalid UTF-8"));
}

TEST_CASE("Quotes that close are no problem", "[yaml]")
{
    CHECK(yaml_problem("a: 'it''s'\nb: \"say \\\"x\\\"\"\nc: ''\n") == "");
    CHECK(parse("a: 'it''s'\n").root.find("a")->value.text == "it's");
    CHECK(parse("\xEF\xBB\xBF"
                "a: 1\n")
              .root.find("a")
              ->column == 1);
    CHECK(yaml_problem("%YAML 1.2\n---\na: 1\n...\n") == "");
}

TEST_CASE("Several problems of one document are all reported", "[yaml]")
{
    CHECK(parse("a: &x 1\nb: *x\nc: 1\nc: 2\nd: !!int 3\n").problems.size() == 4);
}

TEST_CASE("Documents beyond the limits are refused quickly", "[yaml]")
{
    using Catch::Contains;
    const auto start = std::chrono::steady_clock::now();
    const auto repeated = [](const std::string& text, std::size_t count)
    {
        std::string result;
        for (std::size_t i = 0; i < count; ++i)
            result += text;
        return result;
    };
    CHECK_THAT(yaml_problem(repeated("[", 40)), Contains("nested deeper than 32"));
    CHECK_THAT(yaml_problem(repeated("[", 60'000)), Contains("error:"));
    CHECK_THAT(yaml_problem(repeated("{a:\n", 100'000)), Contains("nested deeper than 32"));
    CHECK_THAT(yaml_problem(repeated("- ", 30'000)), Contains("nested deeper than 32"));
    CHECK_THAT(yaml_problem(repeated("? ", 30'000)), Contains("error:"));
    CHECK_THAT(yaml_problem("a: [" + repeated("1,\n", 120'000) + "1]"), Contains("more than 100000 values"));
    CHECK_THAT(yaml_problem("a: 1\nb: [" + repeated("1,", 40'000) + "1]"),
               Contains("f.yaml:2:1: error: a line of more than 65536 bytes"));
    CHECK_THAT(yaml_problem(repeated("#", yaml_size_limit + 1)), Contains("larger than 1 MiB"));
    CHECK(yaml_problem(std::string(yaml_depth_limit, '[') + std::string(yaml_depth_limit, ']')) == "");
    CHECK_THAT(yaml_problem(std::string(yaml_depth_limit + 1, '[') + std::string(yaml_depth_limit + 1, ']')),
               Contains("nested deeper"));
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(30));
}

TEST_CASE("Plain words mean what the core schema of YAML 1.2 says", "[yaml]")
{
    CHECK(resolve("true").value == fresco::Value(true));
    CHECK(resolve("FALSE").value == fresco::Value(false));
    CHECK(resolve("null").value.is_null());
    CHECK(resolve("~").value.is_null());
    CHECK(resolve("12").value == fresco::Value(12));
    CHECK(resolve("-12").value == fresco::Value(-12));
    CHECK(resolve("+12").value == fresco::Value(12));
    CHECK(resolve("0").value == fresco::Value(0));
    CHECK(resolve("9223372036854775807").value == fresco::Value(std::int64_t{9223372036854775807}));
    CHECK(resolve("-9223372036854775808").value.is_int());
    CHECK(resolve("1e-4").value == fresco::Value(1e-4));
    CHECK(resolve("1E3").value == fresco::Value(1000.0));
    CHECK(resolve("-.5").value == fresco::Value(-0.5));
    CHECK(resolve("1.").value == fresco::Value(1.0));
    for (const char* text :
         {"yes", "on", "No", "1,5", "1_000", "1.2.3", "-", "+", ".", "e5", "nan", "inf", "0x", "2020-01-01", "1e", "--1"})
    {
        INFO(text);
        CHECK(resolve(text).value == fresco::Value(text));
        CHECK(resolve(text).refusal.empty());
    }
    for (const char* text : {"010", "-010", "0x1f", "0o17", ".nan", "-.inf", "1e999", "9223372036854775808"})
    {
        INFO(text);
        CHECK_FALSE(resolve(text).refusal.empty());
        CHECK(resolve(text, false).value == fresco::Value(text));
    }
}
