#pragma once

#include <fresco/value.h>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// \file What the benchmarks share: cases in processes of their own, tables, and the report that prints and keeps these.

namespace bench
{

/// Seconds that a piece of work took.
struct Times
{
    double wall = 0;
    double processor = 0;  ///< All threads together; other programs on the machine do not count.
};

/// Times pieces of work inside a case.
class Measure
{
  public:
    /// Calls `work` `times` times and returns the smallest times of a call. The first time that a Measure is used it also learns
    /// how far the process grew at its peak meanwhile.
    Times times(int times, const std::function<void()>& work);
    /// Megabytes (10^6 bytes); 0 before the first call of times().
    double peak_growth_mb() const { return growth_mb_; }

  private:
    double growth_mb_ = 0;
    bool used_ = false;
};

/// Runs `work` in a child process of its own, so that the memory of one case does not count for the next, and returns the map of
/// figures that it returns, with "peak_mb", by how much the process grew, and "process_mb", how large it was at most, added. If
/// the child throws or dies, the map holds "note" with the reason instead. The calling process must have no other threads.
fresco::Value run_case(const std::function<fresco::Value(Measure&)>& work);

struct Column
{
    std::string key;    ///< In rows and in the JSON.
    std::string title;  ///< With its unit, over the printed column.
    int digits = 2;     ///< After the point, for numbers that are not integers.
};

/// Figures of one comparison: printed with aligned columns, and kept as JSON. Entries that a row lacks are printed as "-".
class Table
{
  public:
    Table(std::string name, std::string caption, std::vector<Column> columns);

    /// Keys without a column are kept only in the JSON.
    void add(fresco::Value row);
    const std::string& name() const { return name_; }
    const fresco::Value::List& rows() const { return rows_; }
    std::string text() const;

  private:
    std::string cell(const fresco::Value& row, const Column& column) const;

    std::string name_;
    std::string caption_;
    std::vector<Column> columns_;
    fresco::Value::List rows_;
};

/// How many times as much `more` is as `less`; null unless both are numbers above zero.
fresco::Value ratio(const fresco::Value& more, const fresco::Value& less);

/// The number, or null for one that is not finite, which JSON does not have.
fresco::Value figure(double number);

/// The entry, or null.
fresco::Value entry(const fresco::Value& row, const std::string& key);

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

/// Reads the command line into the options of `app`, prints what `run` measures, and returns the program's exit code: 2 for
/// wrong options, 3 for a missing input, 1 for other errors.
int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& run);

}  // namespace bench
