#pragma once

#include <fresco/value.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file What a stage or component says of one of its options, as data: the host checks a pipeline file by it without opening
/// the library, and the option itself checks what it is set to by the same function.

namespace fresco
{

struct FileFormat
{
    std::string name{};                     ///< "a PLY mesh"
    std::vector<std::string> extensions{};  ///< Lower case, with the dot: ".ply".
    bool is_text = false;                   ///< White space does not count before `begins` and behind `ends`.
    std::vector<std::string> begins{};      ///< The file has one of these at `begins_at`; empty: `holds` tells the format.
    std::size_t begins_at = 0;
    std::vector<std::string> holds{};  ///< It has one of these in its first MiB; "\n" also stands for the beginning.
    std::vector<std::string> ends{};   ///< It has one of these at the end of a text, behind the last header of other files.
    std::size_t length_at = 0;         ///< Offset of its length, a little-endian number of …
    std::size_t length_bytes = 0;      ///< … so many bytes (0: nowhere), …
    std::size_t length_from = 0;       ///< … counted from here.

    static FileFormat from(const Value& description);
    Value describe() const;
};

/// Extensions of all formats, each once.
std::vector<std::string> all_extensions(const std::vector<FileFormat>& formats);

FileFormat json_format();

/// How the folder or file is known that a component is for: what `auto` of a slot that is ByMarks goes by. Plain data, so that
/// the host chooses without opening a library.
struct Marks
{
    /// Names of files and folders that a folder must have, "traj.txt", with '*' and '?' within a name, "seq-*", and '|' between
    /// alternatives, "sparse/cameras.bin|sparse/cameras.txt"; empty: it is for no folder.
    std::vector<std::string> contains{};
    std::vector<FileFormat> formats{};  ///< A file is known by its extension; empty: it is for no file.
    std::vector<std::string> before{};  ///< Types that this one is preferred to where both fit; "*": to every other.

    static Marks from(const Value& description);
    Value describe() const;
};

enum class OptionKind
{
    boolean,
    integer,
    number,
    text,
    integers,
    numbers,
    input_file,
    input_folder,
    input_path,
    output_name,
    component,
    components,
    input_files,   ///< A list of files; a map name as written -> absolute path once it is checked.
    command_line,  ///< A program and its words, which name files and ports of the same stage in braces.
    input_ports,   ///< A map of ports; name -> {artifact, version, as} once it is checked, `as` empty where there is one form.
    output_ports,
    rules  ///< A rule for each part of an artifact (RuleForm); part -> {input, number} once it is checked.
};

/// An artifact that a port may have.
struct PortArtifact
{
    int version = 1;
    std::vector<std::string> as{};  ///< Its exchange forms, the default first; empty where there is one only.
};

/// The part that stands for all parts without a rule of their own.
inline constexpr std::string_view other_parts = "*";

/// Form of a rule for a part: a keyword, or an input name (the rule declares that input) with a number from 0 to 1.
struct RuleForm
{
    std::string parts_of{};  ///< The input whose parts the rules are for: the stage refuses others.
    std::string word{};      ///< "keep"
    std::string input{};     ///< The key of a rule that names an input, and what such an input is called: "texture".
    std::string artifact{};  ///< Artifact of such an input.
    int version = 1;
    std::string number{};  ///< The key of the number; 1 where a rule has none.
};

struct OptionDeclaration
{
    std::string name{};
    OptionKind kind = OptionKind::text;
    Value default_value{};  ///< Null: required, or a slot that may stay empty.
    bool required = false;
    std::optional<double> min{};
    std::optional<double> max{};
    std::vector<std::string> choices{};
    std::vector<std::string> extensions{};  ///< Extensions of an input file, lower case, with the dot; empty: any.
    std::vector<FileFormat> formats{};      ///< Formats of an input file, for those of its extensions that have one.
    bool in_key = true;
    bool is_device = false;  ///< Says whether the stage works on a GPU (fresco::chooses_device).
    std::string component_kind{};
    bool optional = false;     ///< For a component: the word `none` leaves it empty.
    bool of_pipeline = false;  ///< A component that the pipeline chooses for all its stages; listed apart from the options.
    std::string chosen_by{};   ///< Makes `auto` the component whose Marks fit the path in this option.
    std::string for_form{};    ///< A component of the pipeline is left out unless a port of the stage has this exchange form.
    /// For ports: the artifacts that a port may have, by name. Not described: the host knows more of them than the plugin.
    std::map<std::string, PortArtifact> artifacts{};
    std::optional<RuleForm> rule{};  ///< Form of rules.
    std::string help{};

    /// Reads the result of describe(). Throws Error naming the option if it is something else.
    static OptionDeclaration from(const Value& description);
    /// As a map with the keys name, kind, default, min, max, choices, help, …; those that say nothing are left out.
    Value describe() const;

    bool is_ports() const { return kind == OptionKind::input_ports || kind == OptionKind::output_ports; }
    /// The inputs that checked rules name, each once and in the order of their names.
    std::vector<std::string> inputs_named(const Value& rules) const;
    bool is_slot() const { return kind == OptionKind::component || kind == OptionKind::components; }
    /// Accepted values in words: "an integer from 4 to 50000000", "one of unlit, pbr", "the path of an existing file".
    std::string accepted() const;
    /// The default as it is written in a pipeline file; "required" or "none" without one.
    std::string default_text() const;
};

/// One thing that is wrong with a value.
struct ValueProblem
{
    std::vector<std::string> place{};  ///< Keys and positions (from 0) down to the part that is wrong; empty: the value itself.
    std::string wrong{};               ///< "3 is too small"; empty: the part is not even of the kind that is expected.
    std::string expected{};            ///< "an integer from 4 to 50000000"; empty where `wrong` says it all.
};

struct CheckedValue
{
    Value value{};                         ///< As the option holds it; null where there are problems.
    std::vector<ValueProblem> problems{};  ///< All that there are.
};

/// Whether a value fits what is declared, without looking at the disk. Of a component only its form is checked: its options are
/// those of another declaration.
CheckedValue check_value(const OptionDeclaration& option, const Value& value);

}  // namespace fresco
