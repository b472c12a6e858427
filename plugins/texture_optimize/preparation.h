#pragma once

#include "view_source.h"

#include <fresco/torch/loss.h>

#include <torch/types.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fresco::optimize
{

/// A few camera pictures of `views`, spread over them, at the smallest height: RGB in [0,1], 3 x H x W.
std::vector<torch::Tensor> camera_samples(const ViewSource& source, const std::vector<std::size_t>& views,
                                          const torch::Device& device);

/// Prepares every feature network that a loss needs, once, and then every loss, in the order of their names.
void prepare(const std::map<std::string, std::shared_ptr<Loss>>& losses, const PrepareContext& context);

}  // namespace fresco::optimize
