#pragma once

#include "pipeline/problems.h"
#include "pipeline/yaml_document.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

/// \file Vars: which text names which, and their values in place of them, within a budget of size.

namespace fresco::host
{

/// Puts the values of vars in place of `${name}` ("$${" stands for "${"). A text that is nothing but one `${name}` takes the
/// var's value with its type, lists and maps too; in a longer text the var must be a single value. Relative paths in a text that
/// begins with a var count from where that var was set. Vars may use other vars.
class Variables
{
  public:
    /// `vars` is a map name -> value; both must outlive the object.
    Variables(const YamlNode& vars, ProblemList& problems);

    /// The tree with everything put in. What cannot be is reported and becomes an invalid node.
    YamlNode substitute(const YamlNode& node);
    /// Has the var `name`, which there must be, be this value; it must outlive the object. Before the first use.
    void choose(const std::string& name, const YamlNode& value) { vars_.at(name).written = &value; }
    /// Reports what is wrong with those of the vars that nothing used so far.
    void check_unused(const std::set<std::string>& names);

  private:
    struct Var
    {
        const YamlNode* written = nullptr;
        std::optional<YamlNode> value;  ///< Empty before it is first used.
    };

    const YamlNode* value_of(const std::string& name, const YamlNode& use);
    /// Value of a var, if the budget allows it.
    const YamlNode* used_value(const std::string& name, const YamlNode& use);
    YamlNode substitute_scalar(const YamlNode& node);

    std::map<std::string, Var> vars_;
    std::vector<std::string> in_progress_;
    ProblemList& problems_;
    std::size_t budget_;  ///< Bytes and nodes that may still be made: nested vars multiply.
    bool reported_budget_ = false;
};

/// The names in the tree's `${name}`, whether there are such vars or not.
std::set<std::string> vars_named_in(const YamlNode& node);

}  // namespace fresco::host
