#pragma once

#include "table.h"

#include <filesystem>
#include <string>

namespace bench
{

/// Prints tables as they are finished, and writes all of them as one JSON file at the end.
class Report
{
  public:
    /// `settings`: what the figures depend on; printed and kept.
    Report(std::string suite, fresco::Value settings);

    void add(const Table& table);
    /// {"suite", "machine", "settings", "tables": {name: [row …]}}. Throws fresco::Error if the file cannot be written.
    void write(const std::filesystem::path& file) const;

  private:
    fresco::Value all_;
};

}  // namespace bench
