#include "pipeline/pipeline_variables.h"
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <optional>

namespace fresco::host
{
namespace
{
constexpr std::size_t substitution_limit = 4 * yaml_size_limit;
/// What a node counts for, in bytes of text: as many are allowed as in a few files.
constexpr std::size_t node_weight = 16;

/// A stretch of text, or the name of a var.
struct Piece
{
    std::string text;
    bool is_var = false;
};

/// Nothing where a "${" is not closed.
std::optional<std::vector<Piece>> split_references(const std::string& text)
{
    std::vector<Piece> pieces;
    std::string literal;
    const auto end_literal = [&]
    {
        if (!literal.empty())
            pieces.push_back({literal, false});
        literal.clear();
    };
    for (std::size_t i = 0; i < text.size();)
    {
        if (text.compare(i, 3, "$${") == 0)
        {
            literal += "${";
            i += 3;
        }
        else if (text.compare(i, 2, "${") == 0)
        {
            const std::size_t end = text.find('}', i);
            if (end == std::string::npos)
                return std::nullopt;
            end_literal();
            pieces.push_back({text.substr(i + 2, end - i - 2), true});
            i = end + 1;
        }
        else
            literal += text[i++];
    }
    end_literal();
    return pieces;
}

/// The value of a var as it stands where the var is used: placed there, its paths counted from where it was written.
YamlNode placed(const YamlNode& value, const YamlPlace& use)
{
    YamlNode node(value.kind, use);
    node.text = value.text;
    node.plain = value.plain;
    node.origin = value.written_in();
    node.items.reserve(value.items.size());
    for (const YamlNode& item : value.items)
        node.items.push_back(placed(item, use));
    node.entries.reserve(value.entries.size());
    for (const YamlNode::Entry& entry : value.entries)
        node.entries.push_back({use, entry.key, placed(entry.value, use)});
    return node;
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

std::size_t depth(const YamlNode& node)
{
    std::size_t deepest = 0;
    for (const YamlNode& item : node.items)
        deepest = std::max(deepest, depth(item));
    for (const YamlNode::Entry& entry : node.entries)
        deepest = std::max(deepest, depth(entry.value));
    return deepest + 1;
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
        if (const Var& var = vars_.at(name); var.state == State::untouched && !var.written->is_null())
            value_of(name, *var.written);
}

std::vector<std::string> Variables::names() const
{
    std::vector<std::string> result;
    for (const auto& [name, var] : vars_)
        result.push_back(name);
    return result;
}

bool Variables::spend(std::size_t amount, const YamlNode& use)
{
    if (amount <= budget_)
    {
        budget_ -= amount;
        return true;
    }
    if (!reported_budget_)
        problems_.add(use.position(), fmt::format("the vars grow to more than {} MiB of text", substitution_limit >> 20U));
    reported_budget_ = true;
    return false;
}

const YamlNode* Variables::value_of(const std::string& name, const YamlNode& use)
{
    const auto found = vars_.find(name);
    if (found == vars_.end())
    {
        std::string hint = vars_.empty() ? ": declare it under 'vars'" : "";
        if (problems_.takes_hints())
            hint += suggestion(name, names());
        problems_.add(use.position(), "unknown var '" + name + "'" + hint);
        return nullptr;
    }
    Var& var = found->second;
    if (var.state == State::in_progress)
    {
        std::string chain;
        for (auto step = std::find(in_progress_.begin(), in_progress_.end(), name); step != in_progress_.end(); ++step)
            chain += *step + " → ";
        problems_.add(use.position(), "cycle of vars: " + chain + name);
        return nullptr;
    }
    if (var.state == State::untouched)
    {
        // Every name takes a level of the machine's stack.
        if (in_progress_.size() >= yaml_depth_limit)
        {
            problems_.add(use.position(), fmt::format("more than {} nested vars", yaml_depth_limit));
            return nullptr;
        }
        var.state = State::in_progress;
        in_progress_.push_back(name);
        var.value = substitute(*var.written);
        in_progress_.pop_back();
        var.state = State::done;
    }
    if (var.value.is_null())
        problems_.add(use.position(), "the var '" + name + "' has no value: set it with --set " + name + "=…",
                      ProblemKind::missing_input);
    return var.value.is_null() || !var.value.is_valid() ? nullptr : &var.value;
}

YamlNode Variables::substitute_scalar(const YamlNode& node)
{
    const std::optional<std::vector<Piece>> pieces = split_references(node.text);
    if (!pieces)
    {
        problems_.add(node.position(), "a '${' is not closed by '}' (write '$${' for the characters themselves)");
        return YamlNode(YamlNode::Kind::invalid, node);
    }
    if (pieces->size() == 1 && pieces->front().is_var)
    {
        const YamlNode* value = value_of(pieces->front().text, node);
        if (!value || !spend(weight(*value), node))
            return YamlNode(YamlNode::Kind::invalid, node);
        return placed(*value, node);
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
        const YamlNode* value = value_of(piece.text, node);
        if (!value || !spend(weight(*value), node))
        {
            good = false;
            continue;
        }
        if (!value->is_scalar())
        {
            problems_.add(node.position(),
                          "the var '" + piece.text + "' is " + value->summary() + " and cannot be a part of a text");
            good = false;
            continue;
        }
        if (i == 0)
            result.origin = value->written_in();
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
    // Lists of vars that are lists nest deeper than any file may.
    if (depth(result) > yaml_depth_limit)
    {
        problems_.add(node.position(), fmt::format("the vars nest deeper than {} levels", yaml_depth_limit));
        return YamlNode(YamlNode::Kind::invalid, node);
    }
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
