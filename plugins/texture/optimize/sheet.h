#pragma once

/// \file All levels of a view on a sheet, encoded together: for other devices than the CPU, which would wait for operators on one
/// small level after the other. For evaluation.cpp and rendered_part.cpp.

#include "rendered_part.h"
#include "views.h"

#include <fresco/torch/loss.h>

#include <torch/types.h>

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fresco::optimize
{

/// Lays boxes of the view's levels on a sheet for every network that can encode one and of which losses only want selected
/// features. On any thread.
void get_sheets_ready(ViewData& data, const Demands& demands, const torch::Device& device);

/// Levels of one step. A network encodes all of them when the first layer is asked for. References its arguments.
class SheetLevels final : public Levels
{
  public:
    /// ŵ_l of a term on the view's level of this number.
    using Share = std::function<double(std::size_t, const LossTerm&)>;

    /// `picture`: 3 x H x W, the levels one below the other as in the view's picture, displayed RGB, requiring a gradient.
    SheetLevels(torch::Tensor picture, ViewData& data, const Demands& demands, Share share)
        : picture_(std::move(picture)), data_(data), demands_(demands), share_(std::move(share))
    {
    }

    /// Whether there is a sheet for each of the loss's networks, and the loss reads nothing else.
    bool has_all(const LossNeeds& needs) const;
    bool has(const FeatureNetwork& network) const { return data_.sheets.contains(&network); }

    torch::Tensor selected(const FeatureNetwork& network, const std::string& layer) override;
    torch::Tensor camera_selected(const FeatureNetwork& network, const std::string& layer) override;
    std::vector<LevelColumns> columns(const FeatureNetwork& network, const std::string& layer) override;
    const torch::Tensor& kept(const std::string& name, const std::function<torch::Tensor()>& make) override;

    /// The columns of one of the view's levels.
    torch::Tensor of_level(const FeatureNetwork& network, const std::string& layer, std::size_t level, bool camera);
    std::int64_t fine_count(const FeatureNetwork& network, const std::string& layer, std::size_t level) const;

  private:
    const std::vector<LevelColumns>& counts(const FeatureNetwork& network, const std::string& layer) const;

    torch::Tensor picture_;
    ViewData& data_;
    const Demands& demands_;
    Share share_;
    std::map<const FeatureNetwork*, std::map<std::string, torch::Tensor>> features_;
    std::map<std::pair<const FeatureNetwork*, std::string>, std::vector<torch::Tensor>> split_;
};

}  // namespace fresco::optimize
