#pragma once

#include <fresco/value.h>

#include <string>
#include <vector>

namespace bench
{

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

}  // namespace bench
