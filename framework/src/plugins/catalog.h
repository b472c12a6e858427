#pragma once

#include <fresco/option_declaration.h>
#include <fresco/stage.h>
#include <fresco/value.h>
#include <fresco/wording.h>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

/// \file What plugins declare of their types, as data: the host checks, describes and estimates by it without opening a
/// library.

namespace fresco::host
{

/// What one plugin says of one stage or component type, without the library being open.
struct TypeDescription
{
    std::string type;  ///< As in a pipeline file.
    std::string kind;  ///< "stage", or a component's contract: "loss", "features", "image_io", "reader", …
    std::string help;
    /// Configurable::describe() — options, inputs, outputs — plus, for a stage, `cost` (describe_cost), and for a reader
    /// `artifact` and `extensions`.
    Value declaration;
    std::filesystem::path library;
    std::string library_hash;  ///< Contents of the library and of fresco's own libraries that it runs with.
    Value library_versions;    ///< Map name -> version of the libraries behind it.
    std::size_t place = 0;     ///< Where the library was found, in the order in which places are searched.
};

/// A type that is not used, because a library in an earlier place has it, too.
struct ShadowedType
{
    std::string type;
    std::filesystem::path library;
    std::filesystem::path by;
};

/// A file that looks like a plugin and cannot be used, or a folder of FRESCO_PLUGIN_PATH without plugins.
struct Refusal
{
    std::filesystem::path library;
    std::string reason;  ///< Names what differs, with both values.
    bool is_folder = false;
};

/// A plugin of fresco's own that the build left out.
struct UnbuiltPlugin
{
    std::string type;    ///< As in a pipeline file.
    std::string reason;  ///< "libtorch was not found"; empty where it was only not asked for.
};

/// All stages and components that can be used, and why others cannot.
class Catalog
{
  public:
    void add(TypeDescription description);
    void add(Refusal refusal) { refusals_.push_back(std::move(refusal)); }
    void add(UnbuiltPlugin plugin) { unbuilt_.push_back(std::move(plugin)); }

    /// nullptr where no library has the type, or more than one of the first place that has it.
    const TypeDescription* find(std::string_view type) const;
    /// Sorted by type, ambiguous ones left out. Of any kind where `kind` is empty.
    std::vector<const TypeDescription*> types(std::string_view kind = {}) const;
    /// Names of types that more than one library of a place has, sorted.
    std::vector<std::string> ambiguous() const;
    /// Sorted by type.
    std::vector<ShadowedType> shadowed() const;
    const std::vector<Refusal>& refusals() const { return refusals_; }
    const std::vector<UnbuiltPlugin>& unbuilt() const { return unbuilt_; }
    /// nullptr where `type` isn't one of them.
    const UnbuiltPlugin* find_unbuilt(std::string_view type) const;
    /// The libraries that hold `type`: two or more where it is ambiguous.
    std::vector<std::filesystem::path> libraries_of(std::string_view type) const;

  private:
    std::map<std::string, std::vector<TypeDescription>, std::less<>> types_;  ///< Those of the first place that has the type.
    std::multimap<std::string, std::filesystem::path> shadowed_;              ///< Libraries in later places.
    std::vector<Refusal> refusals_;
    std::vector<UnbuiltPlugin> unbuilt_;
};

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

/// A cost as the entry `cost` of TypeDescription::declaration; `options` is the entry beside it. Throws Error naming the
/// type where it names an option that is not there or is of the wrong kind, and where a number is negative or not finite.
Value describe_cost(const std::string& type, const Cost& cost, const Value& options);

}  // namespace fresco::host
