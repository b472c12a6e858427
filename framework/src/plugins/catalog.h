#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::host
{

/// What one plugin says of one stage or component type, without the library being open.
struct TypeDescription
{
    std::string type;  ///< "mesh.decimate"
    std::string kind;  ///< "stage", or a component's contract: "loss", "features", "image_io", "reader", …
    std::string help;
    /// Configurable::describe() — options, inputs, outputs — plus, for a stage, `cost` (describe_cost), and for a reader
    /// `artifact` and `extensions`.
    Value declaration;
    std::filesystem::path library;
    std::string library_hash;  ///< Contents of the library and of fresco's own libraries that it runs with.
    Value library_versions;    ///< Map name -> version of the libraries behind it.
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
    std::string type;    ///< "texture.optimize"
    std::string reason;  ///< "libtorch was not found"; empty where it was only not asked for.
};

/// All stages and components that can be used, and why others cannot.
class Catalog
{
  public:
    void add(TypeDescription description);
    void add(Refusal refusal);
    void add(UnbuiltPlugin plugin);

    /// nullptr where no library, or more than one, has the type.
    const TypeDescription* find(std::string_view type) const;
    /// Sorted by type, ambiguous ones left out.
    std::vector<const TypeDescription*> types() const;
    /// Names of types that more than one library has, sorted.
    std::vector<std::string> ambiguous() const;
    const std::vector<Refusal>& refusals() const { return refusals_; }
    const std::vector<UnbuiltPlugin>& unbuilt() const { return unbuilt_; }
    /// nullptr where `type` isn't one of them.
    const UnbuiltPlugin* find_unbuilt(std::string_view type) const;
    /// The libraries that hold `type`: two or more where it is ambiguous.
    std::vector<std::filesystem::path> libraries_of(std::string_view type) const;

  private:
    std::map<std::string, std::vector<TypeDescription>, std::less<>> types_;
    std::vector<Refusal> refusals_;
    std::vector<UnbuiltPlugin> unbuilt_;
};

}  // namespace fresco::host
