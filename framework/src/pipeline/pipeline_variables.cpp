#include "pipeline/pipeline_variables.h"
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/ranges.h>
#include <optional>
#include <ranges>

namespace fresco::host
{
namespace
{
constexpr std::size_t substitution_limit = 4 * yaml_size_limit;
/// Weight of a node, in bytes of text: as many are allowed as in a few files.
constexpr std::size_t node_weight = 16;

/// A stretch of text, or the name of a var.
struct Piece
{
    std::string text;
    bool is_var = false;
};

/// Returns nothing if a "${" is not closed.
std::optional<std::vector<Piece>> split_references(const std::string& text)
{
    std::vector<Piece> pieces;
    for (std::size_t at = 0; at < text.size();)
    {
        const std::size_t begin = std::min(text.find("${", at), text.size());
        const bool escaped = begin > at && begin < text.size() && text[begin - 1] == '$';
        if (escaped)
            pieces.push_back({text.substr(at, begin - 1 - at) + "${", false});
        else if (begin > at)
            pieces.push_back({text.substr(at, begin - at), false});
        at = escaped ? begin + 2 : begin;
        if (escaped || begin == text.size())
            continue;
        const std::size_t end = text.find('}', begin);
        if (end == std::string::npos)
            return std::nullopt;
        pieces.push_back({text.substr(begin + 2, end - begin - 2), true});
        at = end + 1;
    }
    return pieces;
}

/// Has the value of a var stand where the var is used, its paths counted from where it was written. A mistake in one from the
/// command line is to be mended there.
void place(YamlNode& node, const YamlPlace& use)
{
    node.origin = node.written_in();
    if (!node.from_command_line())
        node.stand_at(use);
    for (YamlNode& item : node.items)
        place(item, use);
    for (YamlNode::Entry& entry : node.entries)
    {
        static_cast<YamlPlace&>(entry) = use;
        place(entry.value, use);
    }
}

std::size_t weight(const YamlNode& node)
{
    std::size_t sum = node.text.size() + node_weight;
    for (const YamlNode& item : node.items)
        sum += weight(item);
    for (const YamlNode::Entry& entry : node.entries)
        sum += weight(entry.value) + entry.key.size();
    return sum;
}
}  // namespace

Variables::Variables(const YamlNode& vars, ProblemList& problems) : problems_(problems), budget_(substitution_limit)
{
    for (const YamlNode::Entry& entry : vars.entries)
        vars_[entry.key].written = &entry.value;
}

void Variables::check_unused(const std::set<std::string>& names)
{
    for (const std::string& name : names)
        if (const Var& var = vars_.at(name); !var.value && !var.written->is_null())
            value_of(name, *var.written);
}

const YamlNode* Variables::used_value(const std::string& name, const YamlNode& use)
{
    const YamlNode* value = value_of(name, use);
    const std::size_t amount = value ? weight(*value) : 0;
    if (amount <= budget_)
    {
        budget_ -= amount;
        return value;
    }
    if (!std::exchange(reported_budget_, true))
        problems_.add(use, fmt::format("the vars grow to more than {} MiB of text", substitution_limit >> 20U));
    return nullptr;
}

const YamlNode* Variables::value_of(const std::string& name, const YamlNode& use)
{
    const auto found = vars_.find(name);
    if (found == vars_.end())
    {
        problems_.add(use, "unknown var '" + name + "'" + problems_.hint(name, std::views::keys(vars_)));
        return nullptr;
    }
    Var& var = found->second;
    if (std::ranges::find(in_progress_, name) != in_progress_.end())
    {
        problems_.add(use, fmt::format("cycle of vars: {} → {}", fmt::join(in_progress_, " → "), name));
        return nullptr;
    }
    if (!var.value)
    {
        // Every name takes a level of the machine's stack.
        if (in_progress_.size() >= yaml_depth_limit)
        {
            problems_.add(use, fmt::format("more than {} nested vars", yaml_depth_limit));
            return nullptr;
        }
        in_progress_.push_back(name);
        var.value = substitute(*var.written);
        in_progress_.pop_back();
    }
    if (var.value->is_null())
        problems_.add(use, "the var '" + name + "' has no value: set it with --set " + name + "=…", ProblemKind::missing_input);
    return var.value->is_null() || !var.value->is_valid() ? nullptr : &*var.value;
}

YamlNode Variables::substitute_scalar(const YamlNode& node)
{
    const std::optional<std::vector<Piece>> pieces = split_references(node.text);
    if (!pieces)
    {
        problems_.add(node, "a '${' is not closed by '}' (write '$${' for the characters themselves)");
        return YamlNode(YamlNode::Kind::invalid, node);
    }
    if (pieces->size() == 1 && pieces->front().is_var)
    {
        const YamlNode* value = used_value(pieces->front().text, node);
        if (!value)
            return YamlNode(YamlNode::Kind::invalid, node);
        YamlNode placed = *value;
        place(placed, node);
        return placed;
    }
    YamlNode result = node;
    result.text.clear();
    result.plain = false;
    bool good = true;
    for (std::size_t i = 0; i < pieces->size(); ++i)
    {
        const Piece& piece = (*pieces)[i];
        if (!piece.is_var)
        {
            result.text += piece.text;
            continue;
        }
        const YamlNode* value = used_value(piece.text, node);
        if (value && !value->is_scalar())
            problems_.add(node, "the var '" + piece.text + "' is " + value->summary() + " and cannot be a part of a text");
        good = good && value && value->is_scalar();
        if (!good)
            continue;
        if (i == 0)
        {
            result.origin = value->written_in();
            if (value->from_command_line())
                result.stand_at(*value);
        }
        result.text += value->text;
    }
    return good ? result : YamlNode(YamlNode::Kind::invalid, node);
}

YamlNode Variables::substitute(const YamlNode& node)
{
    if (node.is_scalar())
        return node.text.find("${") == std::string::npos ? node : substitute_scalar(node);
    YamlNode result = node;
    for (YamlNode& item : result.items)
        item = substitute(item);
    for (YamlNode::Entry& entry : result.entries)
        entry.value = substitute(entry.value);
    return result;
}

std::set<std::string> vars_named_in(const YamlNode& node)
{
    std::set<std::string> names;
    for (std::vector<const YamlNode*> open{&node}; !open.empty();)
    {
        const YamlNode& next = *open.back();
        open.pop_back();
        if (next.is_scalar() && next.text.find("${") != std::string::npos)
            for (Piece& piece : split_references(next.text).value_or(std::vector<Piece>{}))
                if (piece.is_var)
                    names.insert(std::move(piece.text));
        for (const YamlNode& item : next.items)
            open.push_back(&item);
        for (const YamlNode::Entry& entry : next.entries)
            open.push_back(&entry.value);
    }
    return names;
}

}  // namespace fresco::host
