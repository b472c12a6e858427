#pragma once

#include <fresco/value.h>

#include <algorithm>
#include <regex>
#include <stdexcept>
#include <string>

/// \file As much of a JSON Schema validator as the tests of the editor schema need.

namespace fresco::host::testing
{

class SchemaCheck
{
  public:
    explicit SchemaCheck(const Value& schema) : root_(schema) {}

    bool accepts(const Value& value) const { return accepts(root_, value); }

  private:
    static bool has_type(const Value& value, const std::string& type)
    {
        if (type == "object")
            return value.is_map();
        if (type == "array")
            return value.is_list();
        if (type == "string")
            return value.is_string();
        if (type == "boolean")
            return value.is_bool();
        if (type == "integer")
            return value.is_int();
        if (type == "number")
            return value.is_number();
        if (type == "null")
            return value.is_null();
        throw std::runtime_error("the schema has the unknown type " + type);
    }

    const Value& definition(const std::string& reference) const
    {
        const std::string prefix = "#/$defs/";
        if (reference.rfind(prefix, 0) != 0)
            throw std::runtime_error("the schema has the odd reference " + reference);
        return root_.at("$defs").at(reference.substr(prefix.size()));
    }

    static bool all_differ(const Value::List& values)
    {
        for (auto value = values.begin(); value != values.end(); ++value)
            if (std::find(values.begin(), value, *value) != value)
                return false;
        return true;
    }

    bool accepts(const Value& schema, const Value& value) const
    {
        bool good = true;
        for (const auto& [key, rule] : schema.as_map())
            good = good && obeys(schema, key, rule, value);
        return good;
    }

    bool obeys(const Value& schema, const std::string& key, const Value& rule, const Value& value) const
    {
        if (key == "$ref")
            return accepts(definition(rule.as_string()), value);
        if (key == "type")
            return has_type(value, rule.as_string());
        if (key == "const")
            return value == rule;
        if (key == "enum")
            return std::find(rule.as_list().begin(), rule.as_list().end(), value) != rule.as_list().end();
        if (key == "minimum")
            return !value.is_number() || value.as_double() >= rule.as_double();
        if (key == "maximum")
            return !value.is_number() || value.as_double() <= rule.as_double();
        if (key == "pattern")
            return !value.is_string() || std::regex_search(value.as_string(), std::regex(rule.as_string()));
        if (key == "required")
            return all_of(rule, [&](const Value& name) { return !value.is_map() || value.find(name.as_string()); });
        if (key == "anyOf")
            return !all_of(rule, [&](const Value& way) { return !accepts(way, value); });
        if (key == "allOf")
            return all_of(rule, [&](const Value& part) { return accepts(part, value); });
        if (key == "if")
        {
            const Value* branch = schema.find(accepts(rule, value) ? "then" : "else");
            return !branch || accepts(*branch, value);
        }
        if (key == "minItems")
            return !value.is_list() || value.as_list().size() >= static_cast<std::size_t>(rule.as_int());
        if (key == "minProperties")
            return !value.is_map() || value.as_map().size() >= static_cast<std::size_t>(rule.as_int());
        if (key == "uniqueItems")
            return !value.is_list() || !rule.as_bool() || all_differ(value.as_list());
        if (key == "items")
            return !value.is_list() || all_of(value, [&](const Value& item) { return accepts(rule, item); });
        if (key == "properties" || key == "additionalProperties" || key == "propertyNames")
            return !value.is_map() || obeys_entries(schema, key, rule, value);
        for (const char* other : {"$schema", "$defs", "title", "description", "default", "then", "else"})
            if (key == other)
                return true;
        throw std::runtime_error("the schema has the unknown key " + key);
    }

    bool obeys_entries(const Value& schema, const std::string& key, const Value& rule, const Value& map) const
    {
        bool good = true;
        for (const auto& [name, entry] : map.as_map())
        {
            const Value* properties = schema.find("properties");
            const bool named = properties && properties->find(name);
            if (key == "propertyNames")
                good = good && accepts(rule, Value(name));
            else if (key == "properties")
                good = good && (!named || accepts(rule.at(name), entry));
            else if (!named)
                good = good && (rule.is_bool() ? rule.as_bool() : accepts(rule, entry));
        }
        return good;
    }

    template <class Predicate>
    static bool all_of(const Value& list, Predicate predicate)
    {
        for (const Value& entry : list.as_list())
            if (!predicate(entry))
                return false;
        return true;
    }

    const Value& root_;
};

}  // namespace fresco::host::testing
