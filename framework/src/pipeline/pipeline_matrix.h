#pragma once

#include "pipeline/pipeline_document.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

/// \file The axes of a matrix and their values, from the file and --set.

namespace fresco::host
{

/// One axis of a matrix: a var and the values that it takes.
struct MatrixAxis
{
    struct Choice
    {
        std::string label;  ///< Short, unique in its axis whatever the case of letters, good as a part of a file name.
        YamlNode value;
        bool chosen = true;
    };
    std::string var;
    std::vector<Choice> choices;
};

inline constexpr std::size_t combination_limit = 1'000'000;
inline constexpr std::size_t axis_limit = 6;

/// The axes of the document's matrix, each a list of values or a map label -> value. Values in a list are labeled by what
/// they are: a path by its stem, or as much more of it as tells it from the others; a number as "var=2"; a list or map by its
/// place. What is wrong is reported; the var of a bad axis becomes an invalid node, so that nobody stumbles over it again.
std::vector<MatrixAxis> read_matrix(PipelineDocument& document, ProblemList& problems);

/// Applies `--set AXIS=VALUE`: a list replaces the axis's values, one value narrows the axis to the choice of that
/// label or text.
void set_axis(MatrixAxis& axis, const YamlNode& value, ProblemList& problems);

/// The chosen combinations: for each axis, the number of its choice; the last axis runs fastest. Nothing if there are more than
/// `combination_limit`.
std::optional<std::vector<std::vector<std::size_t>>> combinations(const std::vector<MatrixAxis>& axes);

}  // namespace fresco::host
