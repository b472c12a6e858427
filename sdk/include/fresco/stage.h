#pragma once

#include <fresco/component.h>
#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/port.h>
#include <fresco/run_context.h>

/// \file The one header that a stage includes: the base class, options, ports, registration.

namespace fresco
{

/// One step of a pipeline. Derive, declare ports and options as members, write `run`, and register with FRESCO_STAGE.
class Stage : public Configurable
{
  public:
    ~Stage() override;
    /// Does the work. Called once, on one thread, in a process of its own. Throws Error for the user's errors.
    virtual void run(RunContext& run) = 0;
    /// For a stage that needs gigabytes: megabytes of a large run. They count until a run was measured; a stage that says 0
    /// runs alone the first time.
    virtual double memory_mb() const;
};

}  // namespace fresco

/// Registers a stage: `FRESCO_STAGE("mesh.decimate", MeshDecimate, "Quadric edge collapse")`, at namespace scope, once per type.
#define FRESCO_STAGE(type, class_name, help) FRESCO_DETAIL_REGISTER(FRESCO_ENTRY_STAGE, type, "stage", class_name, help)

/// Registers a component of a contract: `FRESCO_COMPONENT("loss.gram", GramLoss, fresco::Loss, "Gram matrices")`.
#define FRESCO_COMPONENT(type, class_name, contract, help)                                                                       \
    FRESCO_DETAIL_REGISTER(FRESCO_ENTRY_COMPONENT, type, contract::component_kind.data(), class_name, help)
