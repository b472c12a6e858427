#include <fresco/error.h>
#include <fresco/value.h>

namespace fresco
{
namespace
{

[[noreturn]] void wrong_kind(std::string_view wanted, const Value& value)
{
    throw Error("expected " + std::string(wanted) + ", found " + std::string(value.kind_name()) + " " + to_json(value));
}

}  // namespace

bool Value::as_bool() const
{
    if (const auto* v = std::get_if<bool>(&data_))
        return *v;
    wrong_kind("true or false", *this);
}

std::int64_t Value::as_int() const
{
    if (const auto* v = std::get_if<std::int64_t>(&data_))
        return *v;
    wrong_kind("a whole number", *this);
}

double Value::as_double() const
{
    if (const auto* v = std::get_if<double>(&data_))
        return *v;
    if (const auto* v = std::get_if<std::int64_t>(&data_))
        return static_cast<double>(*v);
    wrong_kind("a number", *this);
}

const std::string& Value::as_string() const
{
    if (const auto* v = std::get_if<std::string>(&data_))
        return *v;
    wrong_kind("text", *this);
}

const Value::List& Value::as_list() const
{
    if (const auto* v = std::get_if<List>(&data_))
        return *v;
    wrong_kind("a list", *this);
}

Value::List& Value::as_list()
{
    if (auto* v = std::get_if<List>(&data_))
        return *v;
    wrong_kind("a list", *this);
}

const Value::Map& Value::as_map() const
{
    if (const auto* v = std::get_if<Map>(&data_))
        return *v;
    wrong_kind("a map", *this);
}

Value::Map& Value::as_map()
{
    if (auto* v = std::get_if<Map>(&data_))
        return *v;
    wrong_kind("a map", *this);
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

}  // namespace fresco
