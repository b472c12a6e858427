#pragma once

#include <fresco/value.h>

#include <string>
#include <string_view>
#include <vector>

namespace fresco::recordings
{

/// A map of a JSON file that knows its place, so that every error names it. Where it has not got a value, a second map stands in
/// (a frame's own values go before the file's). Both must outlive it.
class JsonRecord
{
  public:
    /// `place` such as "transforms.json: frame 3". Throws Error if `own` is no map.
    JsonRecord(const Value& own, const Value& other, std::string place);
    explicit JsonRecord(const Value& own, std::string place) : JsonRecord(own, own, std::move(place)) {}

    const std::string& place() const { return place_; }
    /// Null where neither has it.
    const Value* find(std::string_view key) const;
    /// Each throws Error naming place and key if the value is missing or of another kind.
    double number(std::string_view key) const;
    double number(std::string_view key, double fallback) const;
    int pixels(std::string_view key) const;  ///< 1 to 65536.
    std::string text(std::string_view key) const;
    /// A list of 3 or 4 rows of 4 numbers; row-major, the fourth row 0 0 0 1 where it is not there.
    std::vector<double> matrix(std::string_view key) const;
    /// The place and the key, for errors.
    std::string place_of(std::string_view key) const;
    /// Throws Error: place, key, `what`.
    [[noreturn]] void fail(std::string_view key, const std::string& what) const;

  private:
    const Value& own_;
    const Value& other_;
    std::string place_;
};

}  // namespace fresco::recordings
