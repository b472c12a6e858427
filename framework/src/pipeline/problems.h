#pragma once

#include "pipeline/pipeline.h"
#include <fresco/wording.h>

#include <string>
#include <vector>

/// \file What is wrong with a pipeline file, each with its place, in the order of the file; hints only for the first ones.

namespace fresco::host
{

/// Collects problems while a pipeline is read, so that all of them are reported at once.
class ProblemList
{
  public:
    void add(Position position, std::string text, ProblemKind kind = ProblemKind::invalid);
    /// Files are reported in the order in which they are announced here, others after them.
    void announce_file(std::string file);
    bool empty() const { return problems_.empty(); }
    std::size_t size() const { return problems_.size(); }
    /// Only the first mistakes of a file get hints: a hint compares a name with all others of the file.
    bool takes_hints() const { return problems_.size() < 200; }
    template <class Names>
    std::string hint(const std::string& name, const Names& known) const
    {
        return takes_hints() ? suggestion(name, {known.begin(), known.end()}) : "";
    }
    /// In the order of the files, lines and columns; equal ones once.
    std::vector<Problem> sorted() const;

  private:
    std::vector<Problem> problems_;
    std::vector<std::string> files_;
};

/// A line per problem, as to_string gives it. One mistake in a long axis is a problem of each of its values: of those at one
/// place, the first few and a count.
std::vector<std::string> told(const std::vector<Problem>& problems);

}  // namespace fresco::host
