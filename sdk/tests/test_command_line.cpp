#include "catch.h"

#include <fresco/command.h>

using namespace fresco;
using Words = std::vector<std::string>;

TEST_CASE("names in braces are found and filled in, doubled braces are braces", "[command_line]")
{
    CHECK(names_in("--out={result}") == Words{"result"});
    CHECK(names_in("{a}:{b.py}") == Words{"a", "b.py"});
    CHECK(names_in("{{\"a\": 1}}").empty());
    CHECK(filled_in("{{{a}}}", {{"a", "/x y"}}) == "{/x y}");
    CHECK(filled_in("plain", {}) == "plain");
    for (const char* word : {"{", "}", "{a", "a}", "{a{b}}", "{{a}"})
    {
        INFO(word);
        CHECK_THROWS_WITH(names_in(word), Catch::Contains("without its other"));
    }
    CHECK_THROWS_WITH(filled_in("{b}", {{"a", ""}}), Catch::Contains("unknown name {b}"));
}

TEST_CASE("a command line is checked against the files and ports beside it", "[command_line]")
{
    const auto option = [](const char* name, OptionKind kind) { return OptionDeclaration{.name = name, .kind = kind}; };
    const std::vector<OptionDeclaration> options{option("words", OptionKind::command_line),
                                                 option("ins", OptionKind::input_ports), option("outs", OptionKind::output_ports),
                                                 option("mine", OptionKind::input_files)};
    struct Case
    {
        const char* words;
        const char* outs;
        std::vector<std::string> problems;  ///< "option word text"; '!' where something is missing.
    };
    const std::vector<Case> cases{
        {R"(["sh", "{a}", "-o{b}", "x.txt", "{x.txt}"])", R"({"b": {}})", {}},
        {R"([])", R"({})", {"words -1 option 'words' is empty: name a program", "outs -1 a command needs at least one output"}},
        {R"(["sh", "{c}"])",
         R"({"b": {}})",
         {"words 1 {c} in 'words' is neither a port nor among 'mine' (there are: a, b, x.txt)",
          "words -1 no word of 'words' says where the output 'b' goes: write \"{b}\" where the program takes the path"}},
        {R"(["sh", "{b"])",
         R"({"a": {}})",
         {"words 1 '{b' has a '{' without its other: a {name} stands for a port's path, {{ for a brace",
          "outs -1 'a' is an input and an output; one needs another name",
          "words -1 no word of 'words' says where the output 'a' goes: write \"{a}\" where the program takes the path"}},
        {R"(["{b}"])", R"({"b": {}})", {"words 0 the program cannot be a {name}: name it, or put its file among 'mine'"}},
        {R"(["bin/tool", "{b}"])",
         R"({"b": {}})",
         {"words 0 'bin/tool' is a relative path that is not among 'mine': add it there"}},
        {R"(["/no/tool", "{b}"])", R"({"b": {}})", {"!words 0 no program '/no/tool': install it, or write its absolute path"}},
    };
    for (const Case& each : cases)
    {
        INFO(each.words << each.outs);
        const Value values = Value::Map{{"words", parse_json(each.words)},
                                        {"ins", parse_json(R"({"a": {}})")},
                                        {"outs", parse_json(each.outs)},
                                        {"mine", parse_json(R"({"x.txt": "/y/x.txt"})")}};
        std::vector<std::string> told;
        for (const auto& problem : check_command_line(options, values, [](const auto&, std::size_t) { return "/none"; }))
            told.push_back((problem.is_missing ? "!" : "") + problem.option + " " + std::to_string(problem.word) + " " +
                           problem.text);
        CHECK(told == each.problems);
    }
}
