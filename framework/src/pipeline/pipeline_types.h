#pragma once

#include "pipeline/problems.h"
#include "pipeline/yaml_document.h"
#include "plugins/catalog.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file Types by name with their declarations, and what is said where one cannot be used. The check of a pipeline looks all
/// types up here.

namespace fresco::host
{

/// A type with its declaration; both live as long as the catalog and the table.
struct KnownType
{
    const TypeDescription* description = nullptr;
    const TypeDeclaration* declaration = nullptr;

    explicit operator bool() const { return declaration != nullptr; }
};

/// Looks types up in the catalog, reads each declaration once, and says what is wrong with a type that cannot be used.
class TypeTable
{
  public:
    explicit TypeTable(const Catalog& catalog) : catalog_(catalog) {}

    const Catalog& catalog() const { return catalog_; }
    /// In silence: nothing where the type is unknown, ambiguous or of another kind.
    KnownType find(std::string_view type, std::string_view kind);
    /// Finds a type, of any kind if `kind` is empty. Reports at `at` why it cannot be used. `user` names its user: "stage
    /// 'mesh'".
    KnownType require(const std::string& type, std::string_view kind, const std::string& user, const Position& at,
                      ProblemList& problems);
    /// All types where `kind` is empty.
    std::vector<std::string> names_of_kind(std::string_view kind) const;
    /// The kinds of component that a pipeline chooses for all its stages, each with the configuration it has by default.
    const std::map<std::string, Value, std::less<>>& pipeline_components();
    /// A stage type whose library an artifact comes with; nullptr for those of the SDK.
    const TypeDescription* owner_of(std::string_view artifact);
    /// A type that the catalog does not have, with ports of a stage's own. The same for equal ones.
    std::shared_ptr<const TypeDescription> adopt(TypeDescription type);
    const TypeDeclaration& declaration(const TypeDescription& type);

  private:
    struct KnownArtifact
    {
        PortArtifact port;
        const TypeDescription* owner = nullptr;
    };
    /// Artifacts of the SDK, and of the ports of all stages.
    const std::map<std::string, KnownArtifact, std::less<>>& artifacts();

    const Catalog& catalog_;
    std::map<const TypeDescription*, TypeDeclaration> declarations_;
    std::map<std::string, KnownArtifact, std::less<>> artifacts_;
    std::optional<std::map<std::string, Value, std::less<>>> pipeline_components_;
    std::map<std::string, std::shared_ptr<const TypeDescription>> adopted_;  ///< By type and ports.
};

/// The type that a configuration names: the word itself, or its `type`. Nothing, and a problem if `problems` is given, where it
/// names none.
std::optional<std::string> type_named_by(const YamlNode& config, const std::string& user, ProblemList* problems);

}  // namespace fresco::host
