#pragma once

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// \file Data without a type of its own: options, reports, descriptions and JSON files, and how a JSON file of a documented form
/// is read.

namespace fresco
{

/// A plain tree of data: what options, reports and descriptors are made of. Maps keep their order. Copyable, no sharing.
class Value
{
  public:
    using List = std::vector<Value>;
    using Entry = std::pair<std::string, Value>;
    using Map = std::vector<Entry>;

    Value();
    Value(bool v);
    Value(int v);
    Value(std::int64_t v);
    Value(std::size_t v);
    Value(double v);
    Value(const char* v);
    Value(std::string v);
    Value(std::string_view v);
    Value(List v);
    Value(Map v);
    Value(const Value& other);
    Value(Value&&) noexcept;
    Value& operator=(const Value&);
    Value& operator=(Value&&) noexcept;
    ~Value();

    bool is_null() const { return std::holds_alternative<std::monostate>(data_); }
    bool is_bool() const { return std::holds_alternative<bool>(data_); }
    bool is_int() const { return std::holds_alternative<std::int64_t>(data_); }
    bool is_number() const { return is_int() || std::holds_alternative<double>(data_); }
    bool is_string() const { return std::holds_alternative<std::string>(data_); }
    bool is_list() const { return std::holds_alternative<List>(data_); }
    bool is_map() const { return std::holds_alternative<Map>(data_); }

    /// Each throws fresco::Error naming both kinds if the value is of another kind; as_double takes integers too.
    bool as_bool() const;
    std::int64_t as_int() const;
    double as_double() const;
    const std::string& as_string() const;
    const List& as_list() const;
    List& as_list();
    const Map& as_map() const;
    Map& as_map();

    /// The entry of a map, or nullptr if there is none or this is no map.
    const Value* find(std::string_view key) const;
    Value* find(std::string_view key);
    /// The entry of a map; throws fresco::Error if there is none.
    const Value& at(std::string_view key) const;
    /// Replaces or appends an entry; a null value becomes a map first.
    void set(std::string_view key, Value value);

    std::string_view kind_name() const;
    friend bool operator==(const Value& a, const Value& b);

  private:
    std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Map> data_;
};

/// JSON text, keys in the map's order, numbers so that they read back exactly. `indent` < 0: one line.
std::string to_json(const Value& value, int indent = -1);
/// Strict JSON (UTF-8, no duplicate keys, at most 64 levels). Throws fresco::Error naming `source` and the byte offset.
Value parse_json(std::string_view text, std::string_view source = "JSON");

/// A value of a JSON file that must have a documented form, with the place where it stands: "tasks.json: groups[1].first".
/// Stages, readers of recordings and the host read such files through it, so that every error names the entry that is wrong.
/// Throws Error; what a file's text must look like is parse_json's business. References the values, which must outlive it.
class JsonPlace
{
  public:
    /// `place`: the file, or the file and what the value is called in it ("transforms.json: frame 3").
    JsonPlace(const Value& value, std::string place) : value_(&value), place_(std::move(place)) {}
    /// Entries that `value` lacks are those of `fallback`: a frame's own values go before the file's.
    JsonPlace(const Value& value, const Value& fallback, std::string place);

    const Value& value() const { return *value_; }
    const std::string& place() const { return place_; }
    /// Throws Error: the place, `problem`.
    [[noreturn]] void fail(const std::string& problem) const;
    /// Throws Error: the place of an entry, `problem`.
    [[noreturn]] void fail(std::string_view key, const std::string& problem) const { at(key).fail(problem); }

    /// An entry of a map, which must be there.
    JsonPlace operator[](std::string_view key) const;
    std::optional<JsonPlace> find(std::string_view key) const;
    /// Refuses entries of other names.
    void has_only(std::initializer_list<std::string_view> keys) const;

    std::vector<JsonPlace> list() const;
    std::vector<JsonPlace> list(std::size_t count) const;  ///< Throws unless it has `count` entries.
    std::vector<std::pair<std::string, JsonPlace>> map() const;
    bool flag() const;
    const std::string& text() const;
    std::vector<std::string> texts() const;
    std::int64_t integer(std::int64_t least = std::numeric_limits<std::int64_t>::min(),
                         std::int64_t most = std::numeric_limits<std::int64_t>::max()) const;
    int size() const;       ///< 1 to 65536; programs write 640.0, too.
    double number() const;  ///< Finite.
    double amount() const;  ///< A number from 0.
    std::vector<double> numbers(std::size_t count) const;

  private:
    JsonPlace at(std::string_view key) const;
    JsonPlace inner(const Value* value, const std::string& step) const;
    [[noreturn]] void expected(const std::string& what) const;

    const Value* value_;
    const Value* fallback_ = nullptr;
    std::string place_;
    bool is_inner_ = false;
};

}  // namespace fresco
