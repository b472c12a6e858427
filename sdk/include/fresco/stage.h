#pragma once

#include <fresco/component.h>
#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/port.h>
#include <fresco/run_context.h>

#include <string>

namespace fresco
{

/// What a stage costs, for `fresco plan`, as formulas over its numeric options (a list: its length as `name_count` and the sum of
/// its squares as `name_squares`), `frames`, `faces` (of its inputs), `height_squares` (the sum of the squares of the heights
/// of its uv maps; 0 without), `cores`, `count(option, "glob")` (files below a folder
/// option) and `bytes(option, "glob")`, with + - * / ( ) min max. A stage that makes frames, faces or uv maps says how many; an
/// empty text passes on its inputs' figures.
struct Cost
{
    std::string seconds = "0";
    std::string memory_mb = "100";
    std::string disk_mb = "0";
    std::string frames{};
    std::string faces{};
    std::string height_squares{};
};

/// One step of a pipeline. Derive, declare ports and options as members, write `run`, and register with FRESCO_STAGE.
class Stage : public Configurable
{
  public:
    ~Stage() override;
    /// Does the work. Called once, on one thread, in a process of its own. Throws Error for the user's errors.
    virtual void run(RunContext& run) = 0;
    /// Rough cost, shown by `plan`; figures measured by earlier runs on this machine go before it.
    virtual Cost cost() const;
};

}  // namespace fresco

/// Registers a stage: `FRESCO_STAGE("mesh.decimate", MeshDecimate, "Quadric edge collapse")`, at namespace scope, once per type.
#define FRESCO_STAGE(type, class_name, help) FRESCO_DETAIL_REGISTER(FRESCO_ENTRY_STAGE, type, "stage", class_name, help)

/// Registers a component of a contract: `FRESCO_COMPONENT("loss.gram", GramLoss, fresco::Loss, "Gram matrices")`.
#define FRESCO_COMPONENT(type, class_name, contract, help)                                                                       \
    FRESCO_DETAIL_REGISTER(FRESCO_ENTRY_COMPONENT, type, contract::component_kind.data(), class_name, help)
