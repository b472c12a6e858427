#pragma once

#include "pipeline/pipeline_matrix.h"

#include <bitset>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace fresco::host
{

/// Axes by their numbers.
using AxisSet = std::bitset<axis_limit>;

/// For each axis the number of its value.
using Choices = std::vector<std::size_t>;

/// The choices of some axes, as a key: equal where those agree.
Choices chosen_of(const AxisSet& axes, const Choices& choices);
/// What they are called: "kitchen,waves".
std::string label_of(const AxisSet& axes, const Choices& choices, const std::vector<MatrixAxis>& matrix);

/// Which vars of a document depend on which axes, directly or through other vars and the axes' values, and which nobody uses.
class VarUse
{
  public:
    VarUse(const YamlNode& vars, const std::vector<MatrixAxis>& axes);

    /// The axes that text with these vars in it depends on; from now on they, and what they are made of, are in use.
    AxisSet use(const std::set<std::string>& names);
    /// The vars that are not in use, by the axes that they depend on.
    std::map<unsigned long, std::set<std::string>> unused() const;

  private:
    struct Var
    {
        std::vector<std::size_t> made_of;
        AxisSet axes;
        bool in_use = false;
    };

    std::vector<std::string> names_;
    std::map<std::string, std::size_t> index_;
    std::vector<Var> vars_;
};

}  // namespace fresco::host
