#include "catch.h"
#include "hand_made_catalog.h"

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{

/// A pipeline of three stages: the first depends on `a`, the second on `b` too, the third on nothing.
std::string pipeline_with(const std::string& matrix, const std::string& vars = "{a: x, b: 1}")
{
    return "version: 1\nvars: " + vars + "\nmatrix: " + matrix + R"(
stages:
  first:  {type: mesh.pass, title: "${a}"}
  second: {type: mesh.pass, input: first, size: "${b}"}
  third:  {type: mesh.pass}
)";
}

Words combination_names(const PipelineResult& result)
{
    return each(result.pipeline.sweep.combinations, &Combination::name);
}

/// Labels of an axis's values, written in flow style.
Words labels(const std::string& values)
{
    return combination_names(check({}, "version: 1\nvars: {a: }\nmatrix: {a: " + values + "}\nstages: {s: {type: mesh.pass}}\n"));
}

}  // namespace

TEST_CASE("a matrix has every combination, and a stage once for all values of the axes that it does not depend on")
{
    const TemporaryFolder folder;
    const auto result = check(folder, pipeline_with("{a: [x, y], b: [1, 2, 3]}"));
    CHECK(lines(result).empty());
    CHECK(combination_names(result) == Words{"x,b=1", "x,b=2", "x,b=3", "y,b=1", "y,b=2", "y,b=3"});
    CHECK(names_of(result) == Words{"first@x", "second@x,b=1", "third", "second@x,b=2", "second@x,b=3", "first@y", "second@y,b=1",
                                    "second@y,b=2", "second@y,b=3"});
    const auto& stages = result.pipeline.stages;
    CHECK(stages[1].own_name == "second");
    CHECK(stages[1].place == "x,b=1");
    CHECK(stages[1].wires.at(0).from_stage == "first@x");
    CHECK(stages[1].options == stages[6].options);  // Checked once for all combinations that the stage is the same in.
    CHECK(stages[8].options->at("size").as_double() == 3);
    CHECK(result.pipeline.sweep.combinations[4].stages == std::vector<std::size_t>{5, 7, 2});
}

TEST_CASE("a stage depends on an axis through other vars, options that are set, and the other axis's values")
{
    const TemporaryFolder folder;
    const std::string vars = R"({a: x, b: 1, whole: "${a}-${b}", root: r})";
    const auto by_var = check(folder, R"(version: 1
vars: )" + vars + R"(
matrix: {a: [x, y], b: [1, 2]}
stages:
  one: {type: mesh.pass, title: "${whole}"}
  two: {type: mesh.pass, title: "${root}"}
)",
                              usual_catalog(), {{"two.size", "${b}"}});
    CHECK(names_of(by_var) == Words{"one@x,b=1", "two@b=1", "one@x,b=2", "two@b=2", "one@y,b=1", "one@y,b=2"});
    CHECK(by_var.pipeline.find("one@y,b=2")->options->at("title").as_string() == "y-2");
    const auto by_value = check(folder, pipeline_with(R"({a: [p, "${b}q"], b: [1, 2]})"));
    CHECK(by_value.pipeline.find("first@b-q,b=2")->options->at("title").as_string() == "2q");
}

TEST_CASE("values are called by what tells them apart, and always by names of folders")
{
    CHECK(labels("[data/kitchen, scans/office/]") == Words{"kitchen", "office"});
    CHECK(labels("[a.jpg, a.png]") == Words{"a.jpg", "a.png"});
    CHECK(labels("[x/room, y/room, z/hall]") == Words{"x-room", "y-room", "z-hall"});
    CHECK(labels("[Room, room.]") == Words{"Room", "room-2"});
    CHECK(labels("[0.5, 1e-4, true]") == Words{"a=0.5", "a=1e-4", "a=true"});
    CHECK(labels("[[1, 2], {x: 3}]") == Words{"a=1", "a=2"});
    CHECK(labels("['', ../.., 'a b/c,d@e']") == Words{"a=1", "a=2", "c-d-e"});
    CHECK(labels("[preview, sweep.json, Report.html]") == Words{"preview-2", "sweep", "Report"});
    CHECK(labels("[küche, 東京]") == Words{"küche", "東京"});
    for (const std::string& label :
         labels("[" + std::string(90, 'a') + "1, " + std::string(90, 'a') + "2, ä" + std::string(34, 'b') + "ä]"))
        CHECK(label.size() <= 38);
}

TEST_CASE("--set narrows an axis to the value of that name or text, or gives it others")
{
    const TemporaryFolder folder;
    const std::string text = pipeline_with("{a: {one: x, two: y.jpg, three: z}, b: [1, 2]}");
    const auto named = check(folder, text, usual_catalog(), {{"a", "two"}});
    CHECK(combination_names(named) == Words{"two,b=1", "two,b=2"});
    CHECK(named.pipeline.find("first@two")->options->at("title").as_string() == "y.jpg");
    CHECK(combination_names(check(folder, text, usual_catalog(), {{"a", "y.jpg"}, {"b", "2"}})) == Words{"two,b=2"});
    // The name of one value is the text of another.
    const std::string crossed = pipeline_with("{a: {one: two, two: x}}");
    CHECK(combination_names(check(folder, crossed, usual_catalog(), {{"a", "two"}})) == Words{"two"});
    CHECK(combination_names(check(folder, text, usual_catalog(), {{"a", "[p, q]"}, {"b", "2"}})) == Words{"p,b=2", "q,b=2"});
    CHECK(lines(check(folder, text, usual_catalog(), {{"a", "tow"}})) ==
          Words{"--set a=tow: error: the axis 'a' of the matrix has no value 'tow' (did you mean 'two'?); for other values, set "
                "a list: --set 'a=[A, B]'"});
    CHECK(lines(check(folder, text, usual_catalog(), {{"a", "[p, p]"}})) ==
          Words{"--set a=[p, p]: error: axis 'a': the text 'p' appears twice; the first is before it"});
}

TEST_CASE("what is wrong with a matrix is reported with its place")
{
    const auto problems = [&](const std::string& matrix, const std::string& vars = "{a: x, b: 1}")
    { return joined_lines(check({}, pipeline_with(matrix, vars))); };
    std::string many;
    std::string long_axis = "\n  a:";
    for (int i = 0; i <= 1000; ++i)
        many += (i == 0 ? "" : ", ") + std::to_string(i);
    for (int i = 0; i < 40'000; ++i)
        long_axis += "\n   - v" + std::to_string(i);
    for (const auto& [matrix, problem] : std::vector<std::pair<std::string, std::string>>{
             {"[a, b]", "3:9: error: 'matrix' must be a map"},
             {"{a: []}", "3:13: error: axis 'a' has no values"},
             {"{a: x}", "3:13: error: axis 'a' must be a list of values or a map {name: value}, got the text 'x'"},
             {"{a: [x, y, x]}", "3:20: error: axis 'a': the text 'x' appears twice"},
             {"{a: [x, ~]}", "3:17: error: axis 'a': empty value"},
             {"{c: [x]}", "3:10: error: matrix: unknown var 'c' (there are: a, b)"},
             {"{a: {a b: x}}", "3:14: error: axis 'a': 'a b' cannot name a folder of results"},
             {"{a: {Preview: x}}", "3:14: error: axis 'a': 'Preview'"},
             {"{a: {p: x, P: y}}", "3:20: error: axis 'a': 'P' differs from another name only in case"},
             {"{a: [" + many + "], b: [" + many + "]}", "3:10: error: the matrix has more than 1000000 combinations"}})
        CHECK_THAT(problems(matrix), StartsWith("p.yaml:" + problem) && !Contains(" | "));
    CHECK_THAT(problems("{1c: [x]}"), StartsWith("p.yaml:3:10: error: '1c' cannot name a var"));
    CHECK(problems(long_axis).empty());
    CHECK_THAT(problems("{a: [x], b: [1], c: [1], d: [1], e: [1], f: [1], g: [1]}", "{a: , b: , c: , d: , e: , f: , g: }"),
               StartsWith("p.yaml:3:10: error: a matrix of more than 6 axes"));
}

TEST_CASE("a problem is reported once, with the values that it comes with")
{
    const auto result = check({}, R"(version: 1
vars: {a: , b: }
matrix: {a: [x, y], b: [1, two, 3]}
stages:
  first:  {type: mesh.pass, title: "${a}", color: red}
  second: {type: mesh.pass, input: first, size: "${b}"}
  third:  {type: "mesh.${a}"}
)");
    const Words found = lines(result);
    REQUIRE(found.size() == 4);
    CHECK_THAT(found[0], StartsWith("p.yaml:5:44: error: stage 'first' (mesh.pass) has no option 'color'"));
    CHECK_THAT(found[1], StartsWith("p.yaml:6:49: ") && EndsWith("got the text 'two' (with b 'two')"));
    CHECK_THAT(found[2], StartsWith("p.yaml:7:18: ") && EndsWith("(with a 'x')"));
    CHECK_THAT(found[3], StartsWith("p.yaml:7:18: ") && EndsWith("(with a 'y')"));
}

TEST_CASE("axes build on the base's: an upper axis goes before it, an empty one removes it, a var that is set is no axis")
{
    const TemporaryFolder folder;
    folder.write("base.yaml", pipeline_with("{a: [x, y], b: [1, 2]}"));
    const auto over = [&](const std::string& text)
    { return combination_names(check(folder, "version: 1\nbase: base.yaml\n" + text)); };
    CHECK(over("vars: {}") == Words{"x,b=1", "x,b=2", "y,b=1", "y,b=2"});
    CHECK(over("matrix: {a: [z]}") == Words{"z,b=1", "z,b=2"});
    CHECK(over("matrix: {a: }") == Words{"b=1", "b=2"});
    CHECK(over("vars: {a: w}") == Words{"b=1", "b=2"});
    CHECK(over("vars: {c: w}\nmatrix: {c: [p, q], b: }") == Words{"x,p", "x,q", "y,p", "y,q"});
    CHECK(over("vars: {a: w, b: 5}").empty());
}

TEST_CASE("vars that are made of each other, tens of thousands in a row, are all found")
{
    // Every 30th is put into the text before the next is looked at, so none nests deeply.
    const TemporaryFolder folder;
    std::string vars = "version: 1\nmatrix: {v0: [1, 2]}\nvars:\n  v0: 1\n";
    std::string title;
    for (int i = 1; i <= 40'000; ++i)
    {
        vars += "  v" + std::to_string(i) + ": \"${v" + std::to_string(i - 1) + "}\"\n";
        if (i % 30 == 0)
            title += "${v" + std::to_string(i) + "}";
    }
    const auto result = check(folder, vars + "stages:\n  s: {type: mesh.pass, title: \"" + title + "\"}\n");
    CHECK(lines(result).empty());
    CHECK(names_of(result) == Words{"s@v0=1", "s@v0=2"});
}

TEST_CASE("files that are handed over are read in place of those on the disk")
{
    const TemporaryFolder folder;
    folder.write("base.yaml", "version: 1\nstages:\n  a: {type: mesh.pass, size: 1}\n");
    folder.write("p.yaml", "version: 1\nbase: base.yaml\nstages:\n  a: {title: old}\n");
    PipelineRequest request{"p.yaml", {}, folder.path()};
    request.texts = load_pipeline(request, usual_catalog()).pipeline.texts;
    folder.write("base.yaml", "no longer a pipeline");
    std::filesystem::remove(folder.path() / "p.yaml");
    const auto result = load_pipeline(request, usual_catalog());
    CHECK(lines(result).empty());
    CHECK(result.pipeline.find("a")->options->at("size").as_double() == 1);
    CHECK(result.pipeline.find("a")->options->at("title") == fresco::Value("old"));
}
