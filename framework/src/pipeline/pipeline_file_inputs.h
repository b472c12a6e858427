#pragma once

#include "pipeline/pipeline_wiring.h"

#include <utility>
#include <vector>

namespace fresco::host
{

/// Wires the `{file: PATH}` of a stage's `input` through readers, and reports what does not fit.
class FileInputs
{
  public:
    FileInputs(TypeTable& types, OptionChecker& options, ProblemList& problems)
        : types_(types), options_(options), problems_(problems)
    {
    }

    /// Sets the stage's `wires`, `uses` and `files_failed`.
    void wire(StageDraft& stage);

  private:
    using Ports = std::vector<const PortDeclaration*>;

    bool wire_file(StageDraft& stage, const Ports& inputs, const YamlNode& node);
    std::vector<std::pair<KnownType, const PortDeclaration*>> readers_for(const Ports& inputs, const std::string& extension,
                                                                          const YamlNode& node, const StageDraft& stage);

    TypeTable& types_;
    OptionChecker& options_;
    ProblemList& problems_;
};

}  // namespace fresco::host
