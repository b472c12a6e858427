#pragma once

#include <fresco/option_declaration.h>
#include <fresco/value.h>
#include <fresco/wording.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// \file What plugins declare of their types, as data: the host checks and describes by it without opening a
/// library.

namespace fresco::host
{

/// The files that decide what a plugin does: its library and fresco's own libraries that it runs with.
class PluginBytes
{
  public:
    explicit PluginBytes(std::vector<std::filesystem::path> files = {}) : files_(std::move(files)) {}
    /// One hash of all, as they are when it is first asked for. Throws Error if one cannot be read.
    const std::string& hash() const;

  private:
    std::vector<std::filesystem::path> files_;
    mutable std::string hash_;
};

/// A stage or component type as its plugin's description has it.
struct TypeDescription
{
    std::string type;  ///< As in a pipeline file.
    std::string kind;  ///< "stage", or a component's contract: "loss", "features", "image_io", "reader", …
    std::string help;
    /// Configurable::describe() — options, components, inputs, outputs — plus, for a stage, `memory_mb`, for a reader
    /// `artifact` and `extensions`, and for a component that has some, `marks`.
    Value declaration;
    std::filesystem::path library{};
    std::shared_ptr<const PluginBytes> bytes = std::make_shared<PluginBytes>();
    Value library_versions{};  ///< Map name -> version of the libraries behind it.
    std::size_t place = 0;     ///< Rank of the folder that has the library, in the order of the search.
};

/// A type that is not used, because a library in an earlier place has it, too.
struct ShadowedType
{
    std::string type;
    std::filesystem::path library;
    std::filesystem::path by;
};

/// A plugin that cannot be used.
struct Refusal
{
    std::filesystem::path library;
    std::string reason;  ///< Names what differs, with both values.
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
    /// Types of an earlier place must be added first.
    void add(TypeDescription description);
    void add(Refusal refusal) { refusals_.push_back(std::move(refusal)); }
    void add(UnbuiltPlugin plugin) { unbuilt_.push_back(std::move(plugin)); }

    /// nullptr where no library has the type, or more than one of the first place that has it.
    const TypeDescription* find(std::string_view type) const;
    /// Sorted by type, ambiguous ones left out. Of any kind where `kind` is empty.
    std::vector<const TypeDescription*> types(std::string_view kind = {}) const;
    /// Names of types that more than one library of a place has, sorted.
    std::vector<std::string> ambiguous() const;
    const std::vector<ShadowedType>& shadowed() const { return shadowed_; }
    const std::vector<Refusal>& refusals() const { return refusals_; }
    const std::vector<UnbuiltPlugin>& unbuilt() const { return unbuilt_; }
    /// nullptr where `type` isn't one of them.
    const UnbuiltPlugin* find_unbuilt(std::string_view type) const;
    /// The libraries that hold `type`: two or more where it is ambiguous.
    std::vector<std::string> libraries_of(std::string_view type) const;

  private:
    std::map<std::string, std::vector<TypeDescription>, std::less<>>
        types_;  ///< The libraries of the first place that has the type.
    std::vector<ShadowedType> shadowed_;
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
    std::vector<std::string> parts;  ///< An output's artifact has these parts, where they are always the same.

    /// "frames", or "frames (version 2)" where the version is not 1.
    std::string artifact_text() const;
};

/// TypeDescription::declaration, read once.
struct TypeDeclaration
{
    std::vector<OptionDeclaration> options;     ///< In declared order.
    std::vector<OptionDeclaration> components;  ///< The kinds of component that it takes from the pipeline's choice.
    std::vector<PortDeclaration> inputs;
    std::vector<PortDeclaration> outputs;
    std::string artifact;                 ///< Artifact that a reader makes.
    std::vector<std::string> extensions;  ///< A reader's: ".png".
    std::vector<FileFormat> formats;      ///< A reader's.
    Marks marks;                          ///< A component's, by which `auto` chooses it.

    const OptionDeclaration* option(std::string_view name) const;
    const PortDeclaration* input(std::string_view name) const;
    const PortDeclaration* output(std::string_view name) const;
    std::vector<std::string> option_names() const;
};

/// Throws Error naming the type where a plugin's description is not of the documented form.
TypeDeclaration read_declaration(const TypeDescription& type);

}  // namespace fresco::host
