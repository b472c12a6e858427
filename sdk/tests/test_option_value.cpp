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
    const char* problem = "";  ///< "place: wrong; expected" of each problem, one a line.
};

std::string text_of(const std::vector<ValueProblem>& problems)
{
    std::string text;
    for (const ValueProblem& problem : problems)
    {
        text += text.empty() ? "" : "\n";
        for (const std::string& step : problem.place)
            text += step + ": ";
        text += problem.wrong + (problem.expected.empty() ? "" : "; " + problem.expected);
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
    {flag, R"("true")", "", "; true or false"},
    {whole, "4", "4"},
    {whole, "3", "", "3 is too small; an integer from 4 to 10"},
    {whole, "11", "", "11 is too large; an integer from 4 to 10"},
    {whole, "5.0", "", "; an integer from 4 to 10"},
    {whole, "null", "", "; an integer from 4 to 10"},
    {from_zero, "0.5", "0.5"},
    {from_zero, "7", "7.0"},
    {from_zero, "-1e-9", "", "-1e-09 is too small; a number of at least 0"},
    {word, R"("x")", R"("x")"},
    {word, "5", "", "; text"},
    {choice, R"("dry")", R"("dry")"},
    {choice, R"("wett")", "", "'wett' is not known (did you mean 'wet'?); one of wet, dry"},
    {wholes, "[]", "[]"},
    {wholes, "[1, 9]", "[1, 9]"},
    {wholes, R"([10, 1, "a"])", "",
     "0: 10 is too large; a list, each entry an integer of at most 9\n2: ; a list, each entry an integer of at most 9"},
    {reals, "[1, 0.5]", "[1.0, 0.5]"},
    {reals, R"({"a": 1})", "", "; a list, each entry a number"},
    {file, R"("./a b/../c")", R"("./a b/../c")"},
    {file, R"("")", R"("")"},
    {file, "3", "", "; the path of an existing file"},
    {folder, R"("/")", R"("/")"},
    {folder, "{}", "", "; the path of an existing folder"},
    {output, R"("a/b c.png")", R"("a/b c.png")"},
    {output, R"("../a")", "", "'../a' is not accepted; a relative path below --out without '..'"},
    {output, R"("/a")", "", "'/a' is not accepted; a relative path below --out without '..'"},
    {output, R"("./a")", "", "'./a' is not accepted: leave out the '.'; a relative path below --out without '..'"},
    {output, R"("a\\b")", "",
     "'a\\b' is not accepted: its folders are parted by '/', not by '\\'; a relative path below --out without '..'"},
    {picture_text, R"("a/b.jpg")", R"("a/b.jpg")"},
    {picture_text, R"("a.gif")", "", "'a.gif' is not accepted; a relative path below --out without '..', ending in .png or .jpg"},
    {picture_text, R"("a/.png")", "",
     "'a/.png' is not accepted: there is no name before the extension; a relative path below --out without '..', "
     "ending in .png or .jpg"},
    {output, R"("a/")", "", "'a/' is not accepted: it names a folder; a relative path below --out without '..'"},
    {output, R"("")", "", "'' is not accepted; a relative path below --out without '..'"},
    {output, "5", "", "; a relative path below --out without '..'"},
    {no_output, R"("")", R"("")"},
    {slot, R"("loss.gram")", R"("loss.gram")"},
    {slot, R"({"type": "loss.gram", "weight": 2})", R"({"type": "loss.gram", "weight": 2})"},
    {slot, "3", "", "; {type: …} of kind 'loss'"},
    {free_slot, R"("none")", "null"},
    {free_slot, "true", "", "; {type: …} of kind 'loss', or none"},
    {slots, R"({"style": "loss.gram", "content": {"type": "x"}})", R"({"style": "loss.gram", "content": {"type": "x"}})"},
    {slots, R"("loss.gram")", "", "; a map {name: {type: …}} of kind 'loss'"},
    {slots, R"({"type": "loss.gram"})", "", "several components are expected: give each a name, {name: {type: …}}"},
    {slots, R"({"a": null, "b": 4})", "",
     "a: 'a' has no value: set {type: …}, or leave the line out\nb: ; {type: …} of kind 'loss'"},
    {line, R"(["sh", "-c", ""])", R"(["sh", "-c", ""])"},
    {line, R"(["sh", {"o": null}, 1])", "", "1: ; a word\n2: ; a word"},
    {files, "[]", "{}"},
    {files, R"(["a.sh", "b/c"])", R"({"a.sh": "a.sh", "b/c": "b/c"})"},
    {files, R"({"a.sh": "/x/a.sh"})", R"({"a.sh": "/x/a.sh"})"},
    {files, R"(["a.sh", 1])", "", "1: ; a word"},
    {ports, R"({"a": "mesh", "b": {"artifact": "image", "as": "png"}, "c": "image"})",
     R"({"a": {"artifact": "mesh", "version": 3, "as": ""}, "b": {"artifact": "image", "version": 1, "as": "png"},
         "c": {"artifact": "image", "version": 1, "as": "npy"}})"},
    {ports, R"({"a": "mash", "b c": "mesh", "d": {"artifact": "mesh", "as": "ply"}})", "",
     "a: port 'a': unknown artifact 'mash' (did you mean 'mesh'?)\n"
     "b c: port 'b c': a name is made of letters, digits, '_' and '-'\n"
     "d: as: port 'd': mesh has only one form; leave 'as' out"},
    {ports, R"({"a": {"artifact": "image", "as": "jpg"}, "b": {"artifact": "mesh", "sa": 1}, "c": null})", "",
     "a: as: ; one of npy, png for 'as' of port 'a'\n"
     "b: sa: port 'b' has no 'sa' (did you mean 'as'?)\n"
     "c: port 'c': expected an artifact such as mesh, or {artifact: …, as: …}"},
    {ports, R"(["mesh"])", "", "; a map {port: artifact} or {port: {artifact: …, as: …}}"},
    {rules, R"({"walls": "waves", "floor": "keep", "*": {"texture": "night", "strength": 0.7}})",
     R"({"*": {"texture": "night", "strength": 0.7}, "floor": {"texture": "keep", "strength": 1.0},
         "walls": {"texture": "waves", "strength": 1.0}})"},
    {rules, R"({"a": {"texture": "waves"}, "b": {"strength": 1, "texture": "keep"}})",
     R"({"a": {"texture": "waves", "strength": 1.0}, "b": {"texture": "keep", "strength": 1.0}})"},
    {rules, "{}", "", "no part has a rule; a map with a rule for each part: keep, a texture, or {texture: …, strength: 0 to 1}"},
    {rules, R"("keep")", "", "; a map with a rule for each part: keep, a texture, or {texture: …, strength: 0 to 1}"},
    {rules, R"({"a": {"textur": "waves"}, "b": {"texture": "waves", "strenght": 1}, "c": {"texture": "waves", "strength": 1.5}})",
     "",
     "a: the rule for 'a' names no texture; keep, the name of a texture, or {texture: …, strength: …}\n"
     "b: strenght: the rule for 'b' has no 'strenght' (did you mean 'strength'?)\n"
     "c: strength: ; a number from 0 to 1 for 'strength' of 'c'"},
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
        CHECK(text_of(checked.problems) == each.problem);
        CHECK(checked.value == parse_json(*each.accepted ? each.accepted : "null"));
        // Accepted values are accepted again: the host passes them to the stage.
        if (checked.problems.empty() && !checked.value.is_null())
            CHECK(check_value(option, checked.value).value == checked.value);
    }
}

TEST_CASE("A part has one rule")
{
    const OptionDeclaration option{
        .name = "it", .kind = OptionKind::rules, .rule = RuleForm{.input = "texture", .number = "strength"}};
    const CheckedValue checked = check_value(option, Value::Map{{"floor", "keep"}, {"floor", "waves"}});
    CHECK(text_of(checked.problems) == "floor: 'floor' has two rules; one rule for each part");
}

TEST_CASE("A declaration is read back as it was written")
{
    for (const char* text :
         {whole, choice, no_output, slot, slots, R"("kind": "numbers", "required": true, "unit": "px", "in_key": false)",
          R"("kind": "components", "component_kind": "loss", "default": "auto",
                                "auto": {"option": "weights", "if_empty": {}, "if_set": {"a": "${weights}"}})"})
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
