#include "catch.h"

#include <fresco/component.h>
#include <fresco/option.h>

using namespace fresco;

namespace
{

struct Case
{
    const char* option;  ///< Beside its name.
    const char* value;
    const char* accepted;      ///< JSON; empty: refused.
    const char* problem = "";  ///< "place: wrong; expected" of each problem, one a line; what the option accepts is left out.
};

std::string text_of(const std::vector<ValueProblem>& problems, const OptionDeclaration& option)
{
    std::string text;
    for (const ValueProblem& problem : problems)
    {
        text += text.empty() ? "" : "\n";
        for (const std::string& step : problem.place)
            text += step + ": ";
        text += problem.wrong.empty() ? "unfit" : problem.wrong;
        text += problem.expected.empty() || problem.expected == option.accepted() ? "" : "; " + problem.expected;
    }
    return text;
}

const char* const flag = R"("kind": "bool")";
const char* const whole = R"("kind": "int", "min": 4, "max": 10)";
const char* const from_zero = R"("kind": "number", "min": 0)";
const char* const word = R"("kind": "text")";
const char* const choice = R"("kind": "text", "choices": ["wet", "dry"])";
const char* const wholes = R"("kind": "ints", "max": 9)";
const char* const reals = R"("kind": "numbers")";
const char* const file = R"("kind": "input_file")";
const char* const folder = R"("kind": "input_folder")";
const char* const output = R"("kind": "output_name", "default": "a.png")";
const char* const picture_text = R"("kind": "output_name", "default": "a.png", "extensions": [".png", ".jpg"])";
const char* const no_output = R"("kind": "output_name", "default": "")";
const char* const slot = R"("kind": "component", "component_kind": "loss", "default": {"type": "loss.gram"})";
const char* const free_slot = R"("kind": "component", "component_kind": "loss")";
const char* const line = R"("kind": "command_line")";
const char* const files = R"("kind": "input_files")";
const char* const ports = R"("kind": "input_ports")";
const char* const rules =
    R"("kind": "rules", "required": true, "rule": {"parts_of": "regions", "word": "keep", "input": "texture",
    "artifact": "texture", "version": 2, "number": "strength"})";
const char* const slots = R"("kind": "components", "component_kind": "loss", "default": {})";

const Case cases[] = {
    {flag, "true", "true"},
    {flag, R"("true")", "", "unfit"},
    {whole, "4", "4"},
    {whole, "3", "", "3 is too small"},
    {whole, "11", "", "11 is too large"},
    {whole, "5.0", "", "unfit"},
    {from_zero, "7", "7.0"},
    {from_zero, "-1e-9", "", "-1e-09 is too small"},
    {word, "5", "", "unfit"},
    {choice, R"("dry")", R"("dry")"},
    {choice, R"("wett")", "", "'wett' is not known (did you mean 'wet'?)"},
    {wholes, "[]", "[]"},
    {wholes, R"([10, 1, "a"])", "", "0: 10 is too large\n2: unfit"},
    {reals, "[1, 0.5]", "[1.0, 0.5]"},
    {file, R"("./a b/../c")", R"("./a b/../c")"},
    {file, R"("")", R"("")"},
    {folder, "{}", "", "unfit"},
    {output, R"("a/b c.png")", R"("a/b c.png")"},
    {output, R"("../a")", "", "'../a' is not accepted"},
    {output, R"("/a")", "", "'/a' is not accepted"},
    {output, R"("./a")", "", "'./a' is not accepted: leave out the '.'"},
    {output, R"("a\\b")", "", "'a\\b' is not accepted: its folders are parted by '/', not by '\\'"},
    {output, R"("a/")", "", "'a/' is not accepted: it names a folder"},
    {output, R"("")", "", "'' is not accepted"},
    {no_output, R"("")", R"("")"},
    {picture_text, R"("a/b.jpg")", R"("a/b.jpg")"},
    {picture_text, R"("a.gif")", "", "'a.gif' is not accepted"},
    {picture_text, R"("a/.png")", "", "'a/.png' is not accepted: there is no name before the extension"},
    {slot, R"("loss.gram")", R"("loss.gram")"},
    {slot, "3", "", "unfit"},
    {free_slot, R"("none")", "null"},
    {slots, R"({"style": "loss.gram", "content": {"type": "x"}})", R"({"style": "loss.gram", "content": {"type": "x"}})"},
    {slots, R"({"type": "loss.gram"})", "", "several components are expected: give each a name, {name: {type: …}}"},
    {slots, R"({"a": null, "b": 4})", "",
     "a: 'a' has no value: set {type: …}, or leave the line out\nb: unfit; {type: …} of kind 'loss'"},
    {line, R"(["sh", "-c", ""])", R"(["sh", "-c", ""])"},
    {line, R"(["sh", {"o": null}, 1])", "", "1: unfit; a word\n2: unfit; a word"},
    {files, R"(["a.sh", "b/c"])", R"({"a.sh": "a.sh", "b/c": "b/c"})"},
    {files, R"({"a.sh": "/x/a.sh"})", R"({"a.sh": "/x/a.sh"})"},
    {files, R"(["a.sh", 1])", "", "1: unfit; a word"},
    {ports, R"({"a": "mesh", "b": {"artifact": "image", "as": "png"}, "c": "image"})",
     R"({"a": {"artifact": "mesh", "version": 3, "as": ""}, "b": {"artifact": "image", "version": 1, "as": "png"},
         "c": {"artifact": "image", "version": 1, "as": "npy"}})"},
    {ports, R"({"a": "mash", "b c": "mesh", "d": {"artifact": "mesh", "as": "ply"}})", "",
     "a: port 'a': unknown artifact 'mash' (did you mean 'mesh'?)\n"
     "b c: port 'b c': a name is made of letters, digits, '_' and '-'\n"
     "d: as: port 'd': mesh has only one form; leave 'as' out"},
    {ports, R"({"a": {"artifact": "image", "as": "jpg"}, "b": {"artifact": "mesh", "sa": 1}, "c": null})", "",
     "a: as: unfit; one of npy, png for 'as' of port 'a'\n"
     "b: sa: port 'b' has no 'sa' (did you mean 'as'?)\n"
     "c: port 'c': expected an artifact such as mesh, or {artifact: …, as: …}"},
    {rules, R"({"walls": "waves", "floor": {"texture": "keep"}, "*": {"texture": "night", "strength": 0.7}})",
     R"({"*": {"texture": "night", "strength": 0.7}, "floor": {"texture": "keep", "strength": 1.0},
         "walls": {"texture": "waves", "strength": 1.0}})"},
    {rules, "{}", "", "no part has a rule"},
    {rules, R"({"b": {"texture": "waves", "strenght": 1}, "c": {"texture": "waves", "strength": 1.5}})", "",
     "b: strenght: the rule for 'b' has no 'strenght' (did you mean 'strength'?)\n"
     "c: strength: unfit; a number from 0 to 1 for 'strength' of 'c'"},
    {rules, R"({"a": {"texture": "keep", "strength": 0.5}, "b": "my waves", "c": 3})", "",
     "a: strength: the rule for 'a' is 'keep', which has no strength\n"
     "b: 'my waves' cannot name a texture: a name is made of letters, digits, '_' and '-'\n"
     "c: the rule for 'c' names no texture; keep, the name of a texture, or {texture: …, strength: …}"},
};

}  // namespace

TEST_CASE("A value fits its declaration, or every problem with it is reported, with its place")
{
    for (const Case& each : cases)
    {
        INFO(each.option << " " << each.value);
        OptionDeclaration option =
            OptionDeclaration::from(parse_json(R"({"name": "it", "help": "", )" + std::string(each.option) + "}"));
        option.artifacts = {{"mesh", {3, {}}}, {"image", {1, {"npy", "png"}}}};
        const CheckedValue checked = check_value(option, parse_json(each.value));
        CHECK(text_of(checked.problems, option) == each.problem);
        CHECK(checked.value == parse_json(*each.accepted ? each.accepted : "null"));
        // Accepted values are accepted again: the host passes them to the stage.
        if (checked.problems.empty() && !checked.value.is_null())
            CHECK(check_value(option, checked.value).value == checked.value);
    }
    const OptionDeclaration option{
        .name = "it", .kind = OptionKind::rules, .rule = RuleForm{.input = "texture", .number = "strength"}};
    const CheckedValue twice = check_value(option, Value::Map{{"floor", "keep"}, {"floor", "waves"}});
    CHECK(text_of(twice.problems, option) == "floor: 'floor' has two rules; one rule for each part");
}

TEST_CASE("A declaration is read back as it was written")
{
    for (const char* text : {whole, choice, no_output, slot, slots, R"("kind": "numbers", "required": true, "in_key": false)"})
    {
        INFO(text);
        const OptionDeclaration option =
            OptionDeclaration::from(parse_json(R"({"name": "it", "help": "Helps", )" + std::string(text) + "}"));
        CHECK(OptionDeclaration::from(option.describe()).describe() == option.describe());
        CHECK(option.describe().at("kind").as_string() == parse_json("{" + std::string(text) + "}").at("kind").as_string());
    }
    CHECK_THROWS_WITH(OptionDeclaration::from(parse_json(R"({"name": "x", "kind": "color", "help": ""})")),
                      Catch::Contains("option 'x' is of the unknown kind 'color'"));
}
