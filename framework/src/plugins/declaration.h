#pragma once

#include "plugins/catalog.h"
#include <fresco/value.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::host
{

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
    output_name,
    component,
    components,
    texts,        ///< A list of words. This and the following: of the built-in type `command` alone.
    input_files,  ///< A list of files; a map name as written -> absolute path once it is checked.
    ports         ///< A map of ports; name -> {artifact, version, as} once it is checked.
};

/// `auto` of a components option: `if_empty` where the owner's option `option` is empty, else `if_set` with "${option}" replaced.
struct AutoRule
{
    std::string option;
    Value if_empty;
    Value if_set;
};

struct OptionDeclaration
{
    std::string name;
    OptionKind kind = OptionKind::text;
    Value default_value;  ///< Null: required, or a slot that may stay empty.
    bool required = false;
    std::optional<double> min;
    std::optional<double> max;
    std::vector<std::string> choices;
    std::string unit;
    bool in_key = true;
    std::string component_kind;
    bool optional = false;  ///< Of a component: the word `none` leaves it empty.
    std::optional<AutoRule> auto_rule;
    std::string help;

    bool is_slot() const { return kind == OptionKind::component || kind == OptionKind::components; }
    /// What is accepted, in words: "an integer from 4 to 50000000", "one of unlit, pbr", "the path of an existing file".
    std::string accepted() const;
    /// The default as it is written in a pipeline file; "required" or "none" where there is none.
    std::string default_text() const;
};

struct PortDeclaration
{
    std::string name;
    std::string artifact;
    int version = 1;
    bool is_optional = false;
    std::string help;

    /// "frames", or "frames (version 2)" where the version is not 1.
    std::string artifact_text() const;
};

/// TypeDescription::declaration, read once.
struct TypeDeclaration
{
    std::vector<OptionDeclaration> options;  ///< In declared order.
    std::vector<PortDeclaration> inputs;
    std::vector<PortDeclaration> outputs;
    std::string artifact;                 ///< Of a reader.
    std::vector<std::string> extensions;  ///< Of a reader: ".png".

    const OptionDeclaration* option(std::string_view name) const;
    const PortDeclaration* input(std::string_view name) const;
    const PortDeclaration* output(std::string_view name) const;
    std::vector<std::string> option_names() const;
};

/// Throws Error naming the type where a plugin's description is not of the documented form.
TypeDeclaration read_declaration(const TypeDescription& type);

/// A number as a user would write it: 4, 0.5, 1e-06.
std::string number_text(double number);

}  // namespace fresco::host
