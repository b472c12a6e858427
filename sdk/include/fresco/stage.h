#pragma once

#include <fresco/component.h>
#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/port.h>
#include <fresco/run_context.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file The one header that a stage includes: the base class, what it costs, options, ports, registration. Costs are plain data:
/// the host carries sizes along the wires and multiplies. Right within a factor of two is good enough, since earlier runs on the
/// machine correct it.

namespace fresco
{

/// How many there are of something: one of `number`, `option`, `squares_of` and `files`, or, where none is set, what the inputs
/// bring; then times, divided and limited. Options are named as in a pipeline file.
struct CostSize
{
    double number = 0;
    std::string option{};      ///< The number in this option.
    std::string squares_of{};  ///< The square of this option, or the sum of the squares of its list.
    std::string files{};       ///< The files below the folder in this option whose paths match `pattern`: "images/*".
    std::string pattern{};
    double bytes_each = 0;                  ///< Of `files`: their bytes, divided by this, instead of their number.
    std::optional<Counted> brought{};       ///< Of steps: what the inputs bring that they are counted by.
    std::vector<std::string> times{};       ///< Options.
    std::vector<std::string> divided_by{};  ///< Options.
    std::string at_most{};                  ///< An option; 0 in it: no limit.

    friend bool operator==(const CostSize&, const CostSize&) = default;
};

struct CostRate
{
    Counted of;
    double each = 0;
};

/// What one of each takes; all of it is added up. Numbers are finite and at least 0.
struct CostRates
{
    double fixed = 0;
    double per_core = 0;  ///< Of memory: what every thread holds.
    std::vector<CostRate> per{};
    double per_step = 0;
};

struct MadeSize
{
    Counted of;
    CostSize size;
};

struct Cost
{
    CostRates seconds{};        ///< On one core.
    double parallel_share = 0;  ///< Of the seconds: the share that all cores work on, 0 to 1.
    CostRates memory_mb{.fixed = 20};
    CostRates disk_mb{};

    /// Where the stage does not pass on its inputs' sizes; the stages behind it count by these. Disk counts what the stage makes.
    /// Seconds and memory count what comes in, or what it makes where none comes in and of sizes that no artifact's wires carry
    /// by themselves.
    std::vector<MadeSize> makes{};
    CostSize steps{};  ///< Of its own work, passed on to nobody.

    /// The option that says whether the stage works on a GPU: true, or the device "cuda". Its "auto" becomes "cuda" or "cpu"
    /// before anything runs, so that the key of a result says where it was made. Empty: never.
    std::string device{};
};

/// One step of a pipeline. Derive, declare ports and options as members, write `run`, and register with FRESCO_STAGE.
class Stage : public Configurable
{
  public:
    ~Stage() override;
    /// Does the work. Called once, on one thread, in a process of its own. Throws Error for the user's errors.
    virtual void run(RunContext& run) = 0;
    /// Rough cost, shown by `plan` until earlier runs on this machine correct it.
    virtual Cost cost() const;
};

}  // namespace fresco

/// Registers a stage: `FRESCO_STAGE("mesh.decimate", MeshDecimate, "Quadric edge collapse")`, at namespace scope, once per type.
#define FRESCO_STAGE(type, class_name, help) FRESCO_DETAIL_REGISTER(FRESCO_ENTRY_STAGE, type, "stage", class_name, help)

/// Registers a component of a contract: `FRESCO_COMPONENT("loss.gram", GramLoss, fresco::Loss, "Gram matrices")`.
#define FRESCO_COMPONENT(type, class_name, contract, help)                                                                       \
    FRESCO_DETAIL_REGISTER(FRESCO_ENTRY_COMPONENT, type, contract::component_kind.data(), class_name, help)
