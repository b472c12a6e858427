#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace fresco
{

/// A plain tree of data: what options, reports and descriptors are made of. Maps keep their order. Copyable, no sharing.
class Value
{
  public:
    using List = std::vector<Value>;
    using Entry = std::pair<std::string, Value>;
    using Map = std::vector<Entry>;

    Value() = default;
    Value(bool v) : data_(v) {}
    Value(int v) : data_(std::int64_t{v}) {}
    Value(std::int64_t v) : data_(v) {}
    Value(std::size_t v) : data_(static_cast<std::int64_t>(v)) {}
    Value(double v) : data_(v) {}
    Value(const char* v) : data_(std::string(v)) {}
    Value(std::string v) : data_(std::move(v)) {}
    Value(std::string_view v) : data_(std::string(v)) {}
    Value(List v) : data_(std::move(v)) {}
    Value(Map v) : data_(std::move(v)) {}
    /// By assignment: where a copy runs out of memory, libstdc++'s constructor destroys what is not there yet.
    Value(const Value& other) { data_ = other.data_; }
    Value(Value&&) noexcept = default;
    Value& operator=(const Value&) = default;
    Value& operator=(Value&&) noexcept = default;
    ~Value() = default;

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
    friend bool operator==(const Value&, const Value&) = default;

  private:
    std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Map> data_;
};

/// JSON text, keys in the map's order, numbers so that they read back exactly. `indent` < 0: one line.
std::string to_json(const Value& value, int indent = -1);
/// Strict JSON (UTF-8, no duplicate keys, at most 64 levels). Throws fresco::Error naming `source` and the byte offset.
Value parse_json(std::string_view text, std::string_view source = "JSON");

}  // namespace fresco
