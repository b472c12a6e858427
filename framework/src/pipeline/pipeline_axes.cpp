#include "pipeline/pipeline_axes.h"
#include "pipeline/pipeline_variables.h"

#include <utility>

namespace fresco::host
{

Choices chosen_of(const AxisSet& axes, const Choices& choices)
{
    Choices result;
    for (std::size_t axis = 0; axis < choices.size(); ++axis)
        if (axes[axis])
            result.push_back(choices[axis]);
    return result;
}

std::string label_of(const AxisSet& axes, const Choices& choices, const std::vector<MatrixAxis>& matrix)
{
    std::string text;
    for (std::size_t axis = 0; axis < choices.size(); ++axis)
        if (axes[axis])
            text += (text.empty() ? "" : ",") + matrix[axis].choices[choices[axis]].label;
    return text;
}

VarUse::VarUse(const YamlNode& vars, const std::vector<MatrixAxis>& axes)
{
    for (const YamlNode::Entry& entry : vars.entries)
    {
        index_[entry.key] = names_.size();
        names_.push_back(entry.key);
    }
    vars_.resize(names_.size());
    std::vector<std::vector<std::size_t>> users(names_.size());
    const auto add = [&](std::size_t var, const YamlNode& value)
    {
        for (const std::string& name : vars_named_in(value))
            if (const auto used = index_.find(name); used != index_.end())
            {
                vars_[var].made_of.push_back(used->second);
                users[used->second].push_back(var);
            }
    };
    std::set<std::string> is_axis;
    for (const MatrixAxis& axis : axes)
    {
        is_axis.insert(axis.var);
        for (const MatrixAxis::Choice& choice : axis.choices)
            add(index_.at(axis.var), choice.value);
    }
    for (const YamlNode::Entry& entry : vars.entries)
        if (!is_axis.contains(entry.key))
            add(index_.at(entry.key), entry.value);
    // Not by recursion: a file may hold a chain of vars that is longer than the machine's stack.
    for (std::size_t axis = 0; axis < axes.size(); ++axis)
        for (std::vector<std::size_t> open{index_.at(axes[axis].var)}; !open.empty();)
        {
            const std::size_t var = open.back();
            open.pop_back();
            if (vars_[var].axes[axis])
                continue;
            vars_[var].axes.set(axis);
            open.insert(open.end(), users[var].begin(), users[var].end());
        }
}

AxisSet VarUse::use(const std::set<std::string>& names)
{
    AxisSet axes;
    std::vector<std::size_t> open;
    for (const std::string& name : names)
        if (const auto var = index_.find(name); var != index_.end())
        {
            axes |= vars_[var->second].axes;
            open.push_back(var->second);
        }
    while (!open.empty())
    {
        Var& var = vars_[open.back()];
        open.pop_back();
        if (!std::exchange(var.in_use, true))
            open.insert(open.end(), var.made_of.begin(), var.made_of.end());
    }
    return axes;
}

std::map<unsigned long, std::set<std::string>> VarUse::unused() const
{
    std::map<unsigned long, std::set<std::string>> result;
    for (std::size_t i = 0; i < vars_.size(); ++i)
        if (!vars_[i].in_use)
            result[vars_[i].axes.to_ulong()].insert(names_[i]);
    return result;
}

}  // namespace fresco::host
