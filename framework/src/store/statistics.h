#pragma once

#include "base/records.h"
#include "store/store.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

/// \file Remembers time and memory of earlier runs. `plan` shows them; the scheduler goes by them.

namespace fresco::host
{

/// Time, memory and disk space of one run of a stage.
struct Usage
{
    double seconds = 0;
    double memory_mb = 0;
    double disk_mb = 0;
};

/// Identifies a stage among earlier runs.
struct StageKind
{
    std::string type;     ///< With the program's name, of a stage that runs one.
    std::string options;  ///< A hash.
};

/// Earlier runs in a store, kept in its Journal stats.jsonl.
class Statistics
{
  public:
    explicit Statistics(const Store& store);
    /// Returns the median time and the greatest memory of the last runs with the same options, else of the type
    /// with these options; nothing if the type never ran.
    std::optional<Usage> last(const StageKind& stage) const;
    /// Returns the same, but nothing if no run had the same options.
    std::optional<Usage> last_with_options(const StageKind& stage) const;
    /// Remembers a run, in the journal too. Throws Error where the journal cannot be written.
    void add(const StageKind& stage, const Usage& took);
    /// Keeps only the last runs of each type and options in the journal. Throws Error.
    void tidy() const;

  private:
    struct Run
    {
        std::string options;
        Usage took;
    };
    void keep(const StageKind& stage, const Usage& took);
    /// nullptr: any options.
    std::optional<Usage> last_of(const std::string& type, const std::string* options) const;

    Journal journal_;
    std::map<std::string, std::vector<Run>> runs_;  ///< The last runs of each type, oldest first.
};

}  // namespace fresco::host
