#include <fresco/error.h>
#include <fresco/value.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

// JSON text for Value, through nlohmann-json's SAX reader so that order is kept, duplicates are seen and depth is bounded.

namespace fresco
{
namespace
{

template <class T, class Data>
auto& held(Data& data, std::string_view wanted, const Value& value)
{
    if (auto* v = std::get_if<T>(&data))
        return *v;
    throw Error("expected " + std::string(wanted) + ", found " + std::string(value.kind_name()) + " " + to_json(value));
}

}  // namespace

// Not inline: each source that makes values would compile the variant again.
Value::Value() = default;
Value::Value(bool v) : data_(v) {}
Value::Value(int v) : data_(std::int64_t{v}) {}
Value::Value(std::int64_t v) : data_(v) {}
Value::Value(std::size_t v) : data_(static_cast<std::int64_t>(v)) {}
Value::Value(double v) : data_(v) {}
Value::Value(const char* v) : data_(std::string(v)) {}
Value::Value(std::string v) : data_(std::move(v)) {}
Value::Value(std::string_view v) : data_(std::string(v)) {}
Value::Value(List v) : data_(std::move(v)) {}
Value::Value(Map v) : data_(std::move(v)) {}
Value::Value(const Value&) = default;
Value::Value(Value&&) noexcept = default;
Value& Value::operator=(const Value&) = default;
Value& Value::operator=(Value&&) noexcept = default;
Value::~Value() = default;

// Clang crashes on a defaulted one: whether it throws depends on itself.
bool operator==(const Value& a, const Value& b)
{
    return a.data_ == b.data_;
}

bool Value::as_bool() const
{
    return held<bool>(data_, "true or false", *this);
}

std::int64_t Value::as_int() const
{
    return held<std::int64_t>(data_, "a whole number", *this);
}

double Value::as_double() const
{
    if (const auto* v = std::get_if<std::int64_t>(&data_))
        return static_cast<double>(*v);
    return held<double>(data_, "a number", *this);
}

const std::string& Value::as_string() const
{
    return held<std::string>(data_, "text", *this);
}

const Value::List& Value::as_list() const
{
    return held<List>(data_, "a list", *this);
}

Value::List& Value::as_list()
{
    return held<List>(data_, "a list", *this);
}

const Value::Map& Value::as_map() const
{
    return held<Map>(data_, "a map", *this);
}

Value::Map& Value::as_map()
{
    return held<Map>(data_, "a map", *this);
}

const Value* Value::find(std::string_view key) const
{
    if (const auto* map = std::get_if<Map>(&data_))
        for (const auto& [name, value] : *map)
            if (name == key)
                return &value;
    return nullptr;
}

Value* Value::find(std::string_view key)
{
    return const_cast<Value*>(std::as_const(*this).find(key));
}

const Value& Value::at(std::string_view key) const
{
    if (const Value* value = find(key))
        return *value;
    throw Error("entry \"" + std::string(key) + "\" is missing in " + to_json(*this).substr(0, 200));
}

void Value::set(std::string_view key, Value value)
{
    if (is_null())
        data_ = Map{};
    if (Value* present = find(key))
        *present = std::move(value);
    else
        as_map().emplace_back(std::string(key), std::move(value));
}

std::string_view Value::kind_name() const
{
    static constexpr std::string_view names[] = {"nothing", "true/false", "a whole number", "a number",
                                                 "text",    "a list",     "a map"};
    return names[data_.index()];
}
namespace
{

void write_text(std::string& out, const std::string& text)
{
    out += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void write_double(std::string& out, double number)
{
    if (!std::isfinite(number))
        throw Error("a number that is not finite cannot be written as JSON");
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, number).ptr;
    const std::string_view text(buffer, static_cast<std::size_t>(end - buffer));
    out += text;
    // A whole double must read back as a double.
    if (text.find_first_of(".e") == std::string_view::npos)
        out += ".0";
}

class JsonWriter
{
  public:
    explicit JsonWriter(int indent) : indent_(indent) {}

    void write(const Value& value, int depth)
    {
        if (value.is_null())
            text += "null";
        else if (value.is_bool())
            text += value.as_bool() ? "true" : "false";
        else if (value.is_int())
            text += std::to_string(value.as_int());
        else if (value.is_number())
            write_double(text, value.as_double());
        else if (value.is_string())
            write_text(text, value.as_string());
        else if (value.is_list())
            write_all(value.as_list(), "[]", depth, [&](const Value& entry) { write(entry, depth + 1); });
        else
            write_all(value.as_map(), "{}", depth,
                      [&](const Value::Entry& entry)
                      {
                          write_text(text, entry.first);
                          text += indent_ < 0 ? ":" : ": ";
                          write(entry.second, depth + 1);
                      });
    }

    std::string text;

  private:
    template <class Entries, class WriteEntry>
    void write_all(const Entries& entries, std::string_view brackets, int depth, const WriteEntry& write_entry)
    {
        text += brackets[0];
        for (const auto& entry : entries)
        {
            if (&entry != &entries.front())
                text += ',';
            new_line(depth + 1);
            write_entry(entry);
        }
        if (!entries.empty())
            new_line(depth);
        text += brackets[1];
    }

    void new_line(int depth)
    {
        if (indent_ < 0)
            return;
        text += '\n';
        text.append(static_cast<std::size_t>(depth * indent_), ' ');
    }

    int indent_;
};

class JsonReader final : public nlohmann::json_sax<nlohmann::json>
{
  public:
    static constexpr std::size_t max_depth = 64;

    bool null() override { return add(Value{}); }
    bool boolean(bool v) override { return add(v); }
    bool number_integer(number_integer_t v) override { return add(Value{std::int64_t{v}}); }
    bool number_unsigned(number_unsigned_t v) override
    {
        if (v > static_cast<number_unsigned_t>(std::numeric_limits<std::int64_t>::max()))
            return add(static_cast<double>(v));
        return add(Value{static_cast<std::int64_t>(v)});
    }
    bool number_float(number_float_t v, const string_t&) override { return add(v); }
    bool string(string_t& v) override { return add(std::move(v)); }
    bool binary(binary_t&) override { return fail("binary data"); }
    bool start_object(std::size_t) override { return open(Value::Map{}); }
    bool key(string_t& name) override
    {
        key_ = std::move(name);
        return true;
    }
    bool end_object() override
    {
        std::set<std::string_view> keys;
        for (const auto& [key, value] : open_.back()->as_map())
            if (!keys.insert(key).second)
                return fail("the key \"" + key + "\" appears twice");
        return close();
    }
    bool start_array(std::size_t) override { return open(Value::List{}); }
    bool end_array() override { return close(); }
    bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override
    {
        // "[json…] parse error at line 1, column 2: syntax error while parsing value - invalid literal; last read: '[N'"
        offset = position;
        std::string_view what = error.what();
        for (const std::string_view before : {": ", " - "})
            if (const auto end = what.find(before); end < what.find("; last read"))
                what.remove_prefix(end + before.size());
        constexpr std::size_t most_shown = 200;
        return fail(std::string(what.size() <= most_shown ? what : what.substr(0, what.find("; last read"))));
    }

    Value root;
    std::string problem;
    std::optional<std::size_t> offset;  ///< Offset of the fault in a text that is not JSON.

  private:
    bool fail(std::string text)
    {
        if (problem.empty())
            problem = std::move(text);
        return false;
    }
    Value* place(Value value)
    {
        if (open_.empty())
        {
            root = std::move(value);
            return &root;
        }
        Value& parent = *open_.back();
        if (parent.is_list())
            return &parent.as_list().emplace_back(std::move(value));
        return &parent.as_map().emplace_back(std::move(key_), std::move(value)).second;
    }
    bool add(Value value) { return place(std::move(value)) != nullptr; }
    bool open(Value container)
    {
        if (open_.size() >= max_depth)
            return fail("nested more than 64 levels deep");
        open_.push_back(place(std::move(container)));
        return true;
    }
    bool close()
    {
        open_.pop_back();
        return true;
    }

    // A container's address is stable while it is open: only its last element grows, and that one is open itself.
    std::vector<Value*> open_;
    std::string key_;
};

}  // namespace

std::string to_json(const Value& value, int indent)
{
    JsonWriter writer(indent);
    writer.write(value, 0);
    return std::move(writer.text);
}

Value parse_json(std::string_view text, std::string_view source)
{
    JsonReader reader;
    if (!nlohmann::json::sax_parse(text.begin(), text.end(), &reader))
        throw Error(fmt::format("{}: not valid JSON{}: {}", source,
                                reader.offset ? fmt::format(" at byte {}", *reader.offset) : "", reader.problem));
    // nlohmann-json takes a NUL for the end of the text.
    if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos)
        throw Error(fmt::format("{}: not valid JSON at byte {}: a NUL character", source, nul + 1));
    return std::move(reader.root);
}

JsonPlace::JsonPlace(const Value& value, const Value& fallback, std::string place)
    : value_(&value), fallback_(&fallback), place_(std::move(place))
{
}

void JsonPlace::fail(const std::string& problem) const
{
    throw Error(place_ + ": " + problem);
}

void JsonPlace::expected(const std::string& what) const
{
    constexpr std::size_t most_shown = 80;
    const bool is_short = !value_->is_map() && !value_->is_list();
    fail("expected " + what + ", got " + (is_short ? to_json(*value_).substr(0, most_shown) : std::string(value_->kind_name())));
}

JsonPlace JsonPlace::inner(const Value* value, const std::string& step) const
{
    JsonPlace entry = *this;
    entry.value_ = value;
    entry.fallback_ = nullptr;
    entry.place_ += step;
    entry.is_inner_ = true;
    return entry;
}

JsonPlace JsonPlace::at(std::string_view key) const
{
    if (!value_->is_map())
        expected("a map");
    const Value* found = value_->find(key);
    if (found == nullptr && fallback_ != nullptr)
        found = fallback_->find(key);
    return inner(found, (is_inner_ ? "." : ": ") + std::string(key));
}

JsonPlace JsonPlace::operator[](std::string_view key) const
{
    JsonPlace entry = at(key);
    if (entry.value_ == nullptr)
        entry.fail("missing");
    return entry;
}

std::optional<JsonPlace> JsonPlace::find(std::string_view key) const
{
    JsonPlace entry = at(key);
    return entry.value_ == nullptr ? std::nullopt : std::optional(std::move(entry));
}

void JsonPlace::has_only(std::initializer_list<std::string_view> keys) const
{
    if (!value_->is_map())
        expected("a map");
    for (const auto& [key, value] : value_->as_map())
        if (std::ranges::find(keys, key) == keys.end())
            fail("unknown entry '" + key + "'");
}

std::vector<JsonPlace> JsonPlace::list() const
{
    if (!value_->is_list())
        expected("a list");
    std::vector<JsonPlace> places;
    for (const Value& entry : value_->as_list())
        places.push_back(inner(&entry, fmt::format("[{}]", places.size())));
    return places;
}

std::vector<JsonPlace> JsonPlace::list(std::size_t count) const
{
    if (!value_->is_list() || value_->as_list().size() != count)
        fail(fmt::format("expected a list of {}", count));
    return list();
}

std::vector<std::pair<std::string, JsonPlace>> JsonPlace::map() const
{
    if (!value_->is_map())
        expected("a map");
    std::vector<std::pair<std::string, JsonPlace>> places;
    for (const auto& [key, value] : value_->as_map())
        places.emplace_back(key, inner(&value, (is_inner_ ? "." : ": ") + key));
    return places;
}

bool JsonPlace::flag() const
{
    if (!value_->is_bool())
        expected("true or false");
    return value_->as_bool();
}

const std::string& JsonPlace::text() const
{
    if (!value_->is_string())
        expected("a text");
    return value_->as_string();
}

std::vector<std::string> JsonPlace::texts() const
{
    std::vector<std::string> result;
    for (const JsonPlace& entry : list())
        result.push_back(entry.text());
    return result;
}

std::int64_t JsonPlace::integer(std::int64_t least, std::int64_t most) const
{
    using Limits = std::numeric_limits<std::int64_t>;
    if (!value_->is_int() || value_->as_int() < least || value_->as_int() > most)
        expected(least == Limits::min()  ? "an integer"
                 : most == Limits::max() ? fmt::format("an integer from {}", least)
                                         : fmt::format("an integer from {} to {}", least, most));
    return value_->as_int();
}

int JsonPlace::size() const
{
    const double count = value_->is_number() ? value_->as_double() : 0;
    if (!(count >= 1 && count <= 65536) || count != std::floor(count))
        expected("a whole number of pixels from 1 to 65536");
    return static_cast<int>(count);
}

double JsonPlace::number() const
{
    if (!value_->is_number() || !std::isfinite(value_->as_double()))
        expected("a number");
    return value_->as_double();
}

double JsonPlace::amount() const
{
    if (!value_->is_number() || !(value_->as_double() >= 0) || std::isinf(value_->as_double()))
        expected("a number from 0");
    return value_->as_double();
}

std::vector<double> JsonPlace::numbers(std::size_t count) const
{
    std::vector<double> result;
    for (const JsonPlace& entry : list(count))
        result.push_back(entry.number());
    return result;
}

}  // namespace fresco
