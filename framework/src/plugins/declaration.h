#pragma once

#include "plugins/catalog.h"
#include <fresco/option_declaration.h>
#include <fresco/value.h>
#include <fresco/wording.h>

#include <string>
#include <string_view>
#include <vector>

namespace fresco::host
{

struct PortDeclaration
{
    std::string name;
    std::string artifact;
    int version = 1;
    bool is_optional = false;
    std::string help;
    std::vector<std::string> parts;  ///< Of an output: the names of the artifact's parts, where they are always the same.

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
    std::vector<FileFormat> formats;      ///< Of a reader.

    const OptionDeclaration* option(std::string_view name) const;
    const PortDeclaration* input(std::string_view name) const;
    const PortDeclaration* output(std::string_view name) const;
    std::vector<std::string> option_names() const;
};

/// Throws Error naming the type where a plugin's description is not of the documented form.
TypeDeclaration read_declaration(const TypeDescription& type);

}  // namespace fresco::host
