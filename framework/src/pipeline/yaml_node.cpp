#include "pipeline/yaml_document.h"
#include "plugins/declaration.h"

#include <algorithm>
#include <charconv>

namespace fresco::host
{
namespace
{
Position position_of(const std::shared_ptr<const YamlSource>& source, int line, int column)
{
    return {source ? source->name : std::string(), line, column};
}

std::string shortened(const std::string& text)
{
    constexpr std::size_t shown = 60;
    if (text.size() <= shown)
        return text;
    std::size_t end = shown;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U)
        --end;
    return text.substr(0, end) + "…";
}
}  // namespace

Position YamlNode::position() const
{
    return position_of(source, line, column);
}

Position YamlNode::Entry::position() const
{
    return position_of(source, line, column);
}

std::filesystem::path YamlNode::path_base() const
{
    const auto& written = origin ? origin : source;
    return written ? written->folder : std::filesystem::path();
}

bool YamlNode::from_command_line() const
{
    const auto& written = origin ? origin : source;
    return written && written->command_line;
}

YamlNode::Entry* YamlNode::find(std::string_view key)
{
    const auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.key == key; });
    return entry == entries.end() ? nullptr : &*entry;
}

const YamlNode::Entry* YamlNode::find(std::string_view key) const
{
    return const_cast<YamlNode*>(this)->find(key);
}

void YamlNode::set(std::string_view key, YamlNode value)
{
    Entry* entry = find(key);
    if (!entry)
        entry = &entries.emplace_back();
    entry->key = std::string(key);
    entry->line = value.line;
    entry->column = value.column;
    entry->source = value.source;
    entry->value = std::move(value);
}

std::string YamlNode::identity() const
{
    std::string result = std::to_string(static_cast<int>(kind)) + (plain ? 'p' : 'q') + std::to_string(text.size()) + ':' + text;
    for (const YamlNode& item : items)
        result += ',' + item.identity();
    for (const Entry& entry : entries)
        result += ';' + std::to_string(entry.key.size()) + ':' + entry.key + '=' + entry.value.identity();
    return result + ')';
}

void YamlNode::erase(std::string_view key)
{
    std::erase_if(entries, [&](const Entry& entry) { return entry.key == key; });
}

std::string YamlNode::summary() const
{
    switch (kind)
    {
    case Kind::null:
        return "nothing";
    case Kind::list:
        return "a list";
    case Kind::map:
        return "a map";
    case Kind::invalid:
        return "something unreadable";
    case Kind::scalar:
        break;
    }
    const ResolvedScalar resolved = resolve_scalar(*this);
    if (resolved.refusal.empty() && resolved.value.is_null())
        return "nothing";
    return resolved.refusal.empty() && !resolved.value.is_string() ? shortened(text) : "the text '" + shortened(text) + "'";
}

YamlNode yaml_from_value(const Value& value, const YamlNode& place)
{
    YamlNode node;
    node.line = place.line;
    node.column = place.column;
    node.source = place.source;
    node.origin = place.origin;
    if (value.is_list())
    {
        node.kind = YamlNode::Kind::list;
        for (const Value& item : value.as_list())
            node.items.push_back(yaml_from_value(item, place));
    }
    else if (value.is_map())
    {
        node.kind = YamlNode::Kind::map;
        for (const auto& [key, entry] : value.as_map())
            node.set(key, yaml_from_value(entry, place));
    }
    else if (!value.is_null())
    {
        node.kind = YamlNode::Kind::scalar;
        node.plain = !value.is_string();
        if (value.is_string())
            node.text = value.as_string();
        else if (value.is_bool())
            node.text = value.as_bool() ? "true" : "false";
        else
            node.text = value.is_int() ? std::to_string(value.as_int()) : number_text(value.as_double());
    }
    return node;
}

namespace
{
bool is_decimal(char c)
{
    return c >= '0' && c <= '9';
}

bool all_digits(std::string_view text)
{
    return !text.empty() && std::all_of(text.begin(), text.end(), is_decimal);
}

/// [-+]? ( . [0-9]+ | [0-9]+ ( . [0-9]* )? ) ( [eE] [-+]? [0-9]+ )?
bool looks_like_float(std::string_view text)
{
    std::size_t i = 0;
    const auto digits = [&]
    {
        const std::size_t start = i;
        while (i < text.size() && is_decimal(text[i]))
            ++i;
        return i - start;
    };
    const std::size_t whole = digits();
    std::size_t fraction = 0;
    if (i < text.size() && text[i] == '.')
    {
        ++i;
        fraction = digits();
    }
    if (whole + fraction == 0)
        return false;
    if (i < text.size() && (text[i] == 'e' || text[i] == 'E'))
    {
        ++i;
        if (i < text.size() && (text[i] == '-' || text[i] == '+'))
            ++i;
        if (digits() == 0)
            return false;
    }
    return i == text.size();
}

ResolvedScalar resolve_number(const std::string& text, std::string_view digits, bool negative)
{
    if (all_digits(digits))
    {
        if (digits.size() > 1 && digits.front() == '0')
            return {{},
                    "'" + text + "' begins with 0, which some readers take for octal: write it without the 0, or '" + text +
                        "' in quotes for text"};
        const std::string signed_digits = (negative ? "-" : "") + std::string(digits);
        std::int64_t number = 0;
        const auto [end, error] = std::from_chars(signed_digits.data(), signed_digits.data() + signed_digits.size(), number);
        if (error != std::errc())
            return {{}, "'" + shortened(text) + "' is too large for an integer"};
        return {Value(number), {}};
    }
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error != std::errc() || end != digits.data() + digits.size())
        return {{}, "'" + shortened(text) + "' is out of the range of numbers"};
    return {Value(negative ? -number : number), {}};
}

bool is_one_of(std::string_view text, std::initializer_list<std::string_view> words)
{
    return std::find(words.begin(), words.end(), text) != words.end();
}
}  // namespace

ResolvedScalar resolve_scalar(const YamlNode& scalar)
{
    const std::string& text = scalar.text;
    if (!scalar.plain)
        return {Value(text), {}};
    if (is_one_of(text, {"", "~", "null", "Null", "NULL"}))
        return {};
    if (is_one_of(text, {"true", "True", "TRUE"}))
        return {Value(true), {}};
    if (is_one_of(text, {"false", "False", "FALSE"}))
        return {Value(false), {}};
    std::string_view digits = text;
    const bool has_sign = digits.front() == '-' || digits.front() == '+';
    const bool negative = digits.front() == '-';
    if (has_sign)
        digits.remove_prefix(1);
    if (is_one_of(digits, {".inf", ".Inf", ".INF"}) || (!has_sign && is_one_of(digits, {".nan", ".NaN", ".NAN"})))
        return {{}, "'" + text + "' is not a finite number"};
    if (looks_like_float(digits))
        return resolve_number(text, digits, negative);
    if (digits.size() > 2 && digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'o') &&
        std::all_of(digits.begin() + 2, digits.end(),
                    [](char c) { return is_decimal(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }))
        return {{}, "'" + text + "' is a number to some readers and text to others: write it in decimal, or in quotes for text"};
    return {Value(text), {}};
}

}  // namespace fresco::host
