#pragma once

/// \file What a loss sees of one level of a rendered view: the Part of the SDK, with features encoded once for all losses and
/// only where the level has pixels. For evaluation.cpp.

#include "views.h"

#include <fresco/torch/loss.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fresco::optimize
{

/// The layers that all losses together want of a network.
struct Demand
{
    std::vector<std::string> image;
    std::vector<std::string> camera;
    bool whole = false;  ///< A loss reads features as a map; else only selected ones, and frames are encoded in crops.
};
using Demands = std::map<const FeatureNetwork*, Demand>;

/// The mask inside `part`, as large as `whole`, which holds it.
Raster8 cut(const Raster8& mask, const PixelBox& part, const PixelBox& whole);

Demands demands_of(const std::map<std::string, std::shared_ptr<Loss>>& losses);

/// Finds the crops and the grids' cells of every level that parts will ask for, which they else find in a view's first step. On
/// any thread.
void get_parts_ready(ViewData& data, const Demands& demands, const torch::Device& device);

class SheetLevels;

/// A level of the view that networks encode on a sheet.
struct OnSheet
{
    SheetLevels* levels = nullptr;  ///< Null: by itself.
    std::size_t number = 0;
};

/// Position of a part in the run.
struct PartPlace
{
    int level = 0;
    std::int64_t step = 0;
    std::int64_t view = 0;
    std::int64_t repeat = 0;
    std::uint64_t seed = 0;
};

/// A part of one rendered level. A network encodes the image once, with all layers in demand, when the first is asked for: the
/// whole of it, or the crops that cover the level's pixels, or on a sheet with all levels. The camera's features are kept in
/// `data` for the next steps on the view. References its arguments.
class RenderedPart final : public Part
{
  public:
    /// `image`: 3 x H x W, displayed RGB, on the run's device, requiring a gradient.
    RenderedPart(PartPlace place, torch::Tensor image, LevelData& data, const Demands& demands, OnSheet sheet = {});

    int level() const override { return place_.level; }
    int height_px() const override { return data_.height_px; }
    std::int64_t step() const override { return place_.step; }
    std::int64_t view() const override { return place_.view; }
    std::int64_t repeat() const override { return place_.repeat; }
    std::uint64_t seed() const override { return place_.seed; }

    torch::Tensor image() override { return image_; }
    torch::Tensor camera() override { return data_.camera; }
    torch::Tensor mask(Pixels pixels) override;

    torch::Tensor features(const FeatureNetwork& network, const std::string& layer) override;
    torch::Tensor camera_features(const FeatureNetwork& network, const std::string& layer) override;
    torch::Tensor feature_mask(const FeatureNetwork& network, const std::string& layer, Pixels pixels) override;
    torch::Tensor selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels) override;
    torch::Tensor camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels) override;
    std::int64_t fine_count(const FeatureNetwork& network, const std::string& layer) override;

    /// Cells of the layer's grid inside the level's masks.
    const GridMask& grid(const FeatureNetwork& network, const std::string& layer);

  private:
    void refuse_unless_whole(const FeatureNetwork& network) const;
    torch::Tensor whole_camera_features(const FeatureNetwork& network, const std::string& layer);
    torch::Tensor enlarged_camera_features(const FeatureNetwork& network, const std::string& layer);
    static torch::Tensor encoded(FeatureMaps& known, const FeatureNetwork& network, const std::vector<std::string>& wanted,
                                 const std::string& layer, const torch::Tensor& picture);
    bool is_on_sheet(const FeatureNetwork& network) const;
    /// Null where the network encodes whole frames.
    CroppedLevel* cropped(const FeatureNetwork& network);
    torch::Tensor selected_in_crops(CroppedLevel& level, const FeatureNetwork& network, const std::string& layer, bool camera);
    const Demand& demand(const FeatureNetwork& network) const;

    PartPlace place_;
    torch::Tensor image_;
    LevelData& data_;
    const Demands& demands_;
    OnSheet sheet_;
    FeatureMaps features_;
    std::map<std::pair<const FeatureNetwork*, std::string>, torch::Tensor> selected_;  ///< Features of Pixels::all.
};

}  // namespace fresco::optimize
