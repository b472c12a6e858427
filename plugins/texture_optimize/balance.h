#pragma once

#include <fresco/stage.h>
#include <fresco/torch/loss.h>

#include <map>
#include <memory>
#include <optional>
#include <string>

namespace fresco::optimize
{

/// Style over content: the summands (by the losses' names) of losses that compare features only with the style picture, over
/// those of losses that compare them with the camera's. None where either is missing or zero.
std::optional<double> style_over_content(const std::map<std::string, std::shared_ptr<Loss>>& losses,
                                         const std::map<std::string, double>& summands);

/// Reports that ratio of the first step as `initial_style_over_content`. Warns where a run that begins without a picture is
/// outside of 0.3 to 8: 1.5 is what the weights of StyleMesh's losses are balanced for, other pictures and
/// layers considered. Where a run begins with a picture, content or style begins small, and the ratio says nothing of the scale.
void report_balance(const std::map<std::string, std::shared_ptr<Loss>>& losses, const std::map<std::string, double>& summands,
                    bool begins_empty, RunContext& run);

}  // namespace fresco::optimize
