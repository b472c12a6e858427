// JSON text for Value, through nlohmann-json's SAX reader so that order is kept, duplicates are seen and depth is bounded.
#include <fresco/error.h>
#include <fresco/value.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <vector>

namespace fresco
{
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
            write_list(value.as_list(), depth);
        else
            write_map(value.as_map(), depth);
    }

    std::string text;

  private:
    void write_list(const Value::List& list, int depth)
    {
        text += '[';
        for (std::size_t i = 0; i < list.size(); ++i)
        {
            separate(i, depth + 1);
            write(list[i], depth + 1);
        }
        close(!list.empty(), depth, ']');
    }

    void write_map(const Value::Map& map, int depth)
    {
        text += '{';
        for (std::size_t i = 0; i < map.size(); ++i)
        {
            separate(i, depth + 1);
            write_text(text, map[i].first);
            text += indent_ < 0 ? ":" : ": ";
            write(map[i].second, depth + 1);
        }
        close(!map.empty(), depth, '}');
    }

    void separate(std::size_t position, int depth)
    {
        if (position > 0)
            text += ',';
        new_line(depth);
    }

    void close(bool any, int depth, char bracket)
    {
        if (any)
            new_line(depth);
        text += bracket;
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

class Reader final : public nlohmann::json_sax<nlohmann::json>
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
        if (const std::string* twice = repeated_key(open_.back()->as_map()))
            return fail("the key \"" + *twice + "\" appears twice");
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
    std::optional<std::size_t> offset;  ///< Of a text that is not JSON.

  private:
    /// Sorted, because a file may hold millions of keys.
    static const std::string* repeated_key(const Value::Map& map)
    {
        std::vector<const std::string*> keys;
        keys.reserve(map.size());
        for (const auto& [key, value] : map)
            keys.push_back(&key);
        std::ranges::sort(keys, {}, [](const std::string* key) -> const std::string& { return *key; });
        const auto twice =
            std::ranges::adjacent_find(keys, {}, [](const std::string* key) -> const std::string& { return *key; });
        return twice == keys.end() ? nullptr : *twice;
    }
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
        {
            parent.as_list().push_back(std::move(value));
            return &parent.as_list().back();
        }
        parent.as_map().emplace_back(std::move(key_), std::move(value));
        return &parent.as_map().back().second;
    }
    bool add(Value value)
    {
        place(std::move(value));
        return true;
    }
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
    Reader reader;
    if (!nlohmann::json::sax_parse(text.begin(), text.end(), &reader))
        throw Error(fmt::format("{}: not valid JSON{}: {}", source,
                                reader.offset ? fmt::format(" at byte {}", *reader.offset) : "", reader.problem));
    // nlohmann-json takes a NUL for the end of the text.
    if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos)
        throw Error(fmt::format("{}: not valid JSON at byte {}: a NUL character", source, nul + 1));
    return std::move(reader.root);
}

}  // namespace fresco
