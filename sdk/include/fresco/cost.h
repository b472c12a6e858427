#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file About what a stage costs, for `fresco plan`: right within a factor of two is good enough, since earlier runs on the
/// machine correct it. Plain data, so that the host needs no library for it: it carries sizes along the wires and multiplies.

namespace fresco
{

/// Something whose number says how large an artifact is, declared beside the artifact's type in the namespace `count`.
struct Counted
{
    std::string_view name;               ///< "faces"
    double assumed = 0;                  ///< Where nothing says how many there are.
    std::string_view carried_by{};       ///< The artifact whose wires carry this number and no other; empty: other wires do, …
    std::string_view also_carried_by{};  ///< … and those of this artifact, where no other wire does.
    const Counted* each_of = nullptr;    ///< Seconds and disk count it for each of these (or each step), memory once.
    double in_square = 1;                ///< How many the square of an option has.

    friend bool operator==(const Counted&, const Counted&) = default;
};

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

}  // namespace fresco
