#pragma once

#include "base/records.h"
#include "store/store.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

/// \file What stages took in earlier runs. `plan` shows it; the scheduler and the time limits of isolated stages go by it.

namespace fresco::host
{

/// What a stage took.
struct Usage
{
    double seconds = 0;
    double memory_mb = 0;
    double disk_mb = 0;
};

/// By what a stage is recognized among earlier runs.
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
    /// Median time and greatest memory of the last runs with the same options; where there are none, of the last runs of the
    /// type; nothing where that never ran.
    std::optional<Usage> last(const StageKind& stage) const;
    /// Remembers a run, also for later processes. Throws Error where the journal cannot be written.
    void add(const StageKind& stage, const Usage& took);
    /// Keeps only the last runs of each type in the journal. Throws Error.
    void tidy() const;

  private:
    struct Run
    {
        std::string options;
        Usage took;
    };
    void keep(const StageKind& stage, const Usage& took);

    Journal journal_;
    std::map<std::string, std::vector<Run>> runs_;  ///< By type, the last ones, oldest first.
};

}  // namespace fresco::host
