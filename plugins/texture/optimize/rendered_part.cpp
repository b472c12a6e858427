#include "rendered_part.h"

#include "sheet.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/upsample_bilinear2d.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <numeric>
#include <span>
#include <stdexcept>

namespace fresco::optimize
{
namespace
{

void add_missing(std::vector<std::string>& names, const std::vector<std::string>& more)
{
    for (const auto& name : more)
        if (std::find(names.begin(), names.end(), name) == names.end())
            names.push_back(name);
}

/// `layer` of a picture; all `wanted` layers are encoded together when the first is asked for, and of each stays what `kept`
/// makes of it, where given.
torch::Tensor
encoded_layer(std::map<std::string, torch::Tensor>& known, const std::vector<std::string>& wanted, const std::string& layer,
              const std::function<std::vector<torch::Tensor>()>& encode,
              const std::function<torch::Tensor(const std::string& layer, const torch::Tensor& maps)>& kept = nullptr)
{
    if (std::find(wanted.begin(), wanted.end(), layer) == wanted.end())
        throw std::logic_error("a loss asks for the layer '" + layer + "', which its needs() do not name");
    if (known.empty())
    {
        auto result = encode();
        if (result.size() != wanted.size())
            throw std::logic_error(
                fmt::format("a feature network gave {} layers for {} asked for", result.size(), wanted.size()));
        for (std::size_t i = 0; i < wanted.size(); ++i)
        {
            const auto maps = std::move(result[i]);
            known.emplace(wanted[i], kept ? kept(wanted[i], maps) : maps);
        }
    }
    return known.at(layer);
}

/// With what nobody reads left out, if the network can do that.
std::vector<torch::Tensor> encoded_around(const FeatureNetwork& network, const torch::Tensor& picture,
                                          const std::vector<std::string>& layers, const ReadPixels& read)
{
    const auto* partial = dynamic_cast<const PartialFeatures*>(&network);
    return partial != nullptr ? partial->encode_around(picture, layers, read) : network.encode(picture, layers);
}

/// Null where the network encodes whole frames of the level.
CroppedLevel* cropped_level(LevelData& data, const FeatureNetwork& network, const Demand& demand, const torch::Device& device)
{
    // Enlarged camera features have no crops, and both must select in one order. Other devices have sheets; for networks that
    // cannot encode these, small crops would be more operators, each as slow as a large one.
    if (demand.whole || data.smallest || !device.is_cpu())
        return nullptr;
    auto found = data.cropped.find(&network);
    if (found == data.cropped.end())
    {
        int align = 1;
        int margin = 0;
        for (const auto& name : demand.image)
        {
            const auto layer = network.layer(name);
            align = std::lcm(align, layer.stride);
            margin = std::max(margin, layer.margin_px);
        }
        CroppedLevel level{covering_crops(data.pixels.all, {align, margin}), {}, {}};
        for (const auto& crop : level.crops)
            level.pixels.push_back(
                {cut(data.pixels.all, crop.core, crop.encoded), cut(data.pixels.all, crop.encoded, crop.encoded)});
        level.grids.resize(level.crops.size());
        found = data.cropped.emplace(&network, std::move(level)).first;
    }
    return &found->second;
}

/// The cells of crop `number`'s core.
const GridMask& crop_grid(const LevelData& data, CroppedLevel& level, std::size_t number, int stride, const torch::Device& device)
{
    auto& known = level.grids[number];
    const auto found = known.find(stride);
    if (found != known.end())
        return found->second;
    const auto& crop = level.crops[number];
    auto mask =
        grid_mask(level.pixels[number].features, cut(data.pixels.fine, crop.core, crop.encoded), stride, Protocol::paper, device);
    return known.emplace(stride, std::move(mask)).first->second;
}

/// Selects from features whose first `fine_count` are fine.
torch::Tensor of_role(const torch::Tensor& features, std::int64_t fine_count, Pixels pixels)
{
    if (pixels == Pixels::all)
        return features;
    return pixels == Pixels::fine ? features.narrow(1, 0, fine_count)
                                  : features.narrow(1, fine_count, features.size(1) - fine_count);
}

}  // namespace

Raster8 cut(const Raster8& mask, const PixelBox& part, const PixelBox& whole)
{
    Raster8 result(whole.x1 - whole.x0, whole.y1 - whole.y0);
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x)
            result.at(x - whole.x0, y - whole.y0) = mask.at(x, y);
    return result;
}

Demands demands_of(const std::map<std::string, std::shared_ptr<Loss>>& losses)
{
    Demands demands;
    for (const auto& [name, loss] : losses)
        for (const auto& layers : loss->needs().features)
        {
            if (layers.network == nullptr)
                throw Error("loss '" + name + "' needs features but names no network");
            auto& demand = demands[layers.network];
            demand.whole = demand.whole || layers.whole;
            add_missing(demand.image, layers.names);
            if (layers.camera)
                add_missing(demand.camera, layers.names);
        }
    return demands;
}

void get_parts_ready(ViewData& data, const Demands& demands, const torch::Device& device)
{
    if (!device.is_cpu())
        get_sheets_ready(data, demands, device);
    for (auto& level : data.levels)
        for (const auto& [network, demand] : demands)
            for (const auto& name : demand.image)
            {
                if (data.sheets.contains(network))
                    continue;
                const int stride = network->layer(name).stride;
                auto* cropped = cropped_level(level, *network, demand, device);
                if (cropped == nullptr)
                    grid_of(level, stride, device);
                else
                    for (std::size_t i = 0; i < cropped->crops.size(); ++i)
                        crop_grid(level, *cropped, i, stride, device);
            }
}

RenderedPart::RenderedPart(PartPlace place, torch::Tensor image, LevelData& data, const Demands& demands, OnSheet sheet)
    : place_(place), image_(std::move(image)), data_(data), demands_(demands), sheet_(sheet)
{
}

const Demand& RenderedPart::demand(const FeatureNetwork& network) const
{
    const auto found = demands_.find(&network);
    if (found == demands_.end())
        throw std::logic_error("a loss asks for features of a network that its needs() do not name");
    return found->second;
}

torch::Tensor RenderedPart::encoded(FeatureMaps& known, const FeatureNetwork& network, const std::vector<std::string>& wanted,
                                    const std::string& layer, const torch::Tensor& picture)
{
    return encoded_layer(known[{&network, 0}], wanted, layer, [&] { return network.encode(picture, wanted); });
}

torch::Tensor RenderedPart::features(const FeatureNetwork& network, const std::string& layer)
{
    refuse_unless_whole(network);
    return encoded(features_, network, demand(network).image, layer, image_);
}

torch::Tensor RenderedPart::mask(Pixels pixels)
{
    if (pixels == Pixels::steep)
        return data_.all.logical_and(data_.fine.logical_not());
    return pixels == Pixels::all ? data_.all : data_.fine;
}

void RenderedPart::refuse_unless_whole(const FeatureNetwork& network) const
{
    if (!demand(network).whole)
        throw std::logic_error("a loss asks for features as a map, but its needs() do not say 'whole'");
}

torch::Tensor RenderedPart::camera_features(const FeatureNetwork& network, const std::string& layer)
{
    refuse_unless_whole(network);
    return whole_camera_features(network, layer);
}

torch::Tensor RenderedPart::whole_camera_features(const FeatureNetwork& network, const std::string& layer)
{
    const at::NoGradGuard no_gradient;
    if (data_.smallest)
        return enlarged_camera_features(network, layer);
    return encoded(data_.camera_features, network, demand(network).camera, layer, data_.camera);
}

torch::Tensor RenderedPart::enlarged_camera_features(const FeatureNetwork& network, const std::string& layer)
{
    auto& known = data_.camera_features[{&network, 0}];
    const auto found = known.find(layer);
    if (found != known.end())
        return found->second;
    const auto small = encoded(data_.smallest->features, network, demand(network).camera, layer, data_.smallest->picture);
    const int stride = network.layer(layer).stride;
    const auto enlarged =
        at::upsample_bilinear2d(small.unsqueeze(0), {image_.size(1) / stride, image_.size(2) / stride}, false).squeeze(0);
    return known.emplace(layer, enlarged).first->second;
}

bool RenderedPart::is_on_sheet(const FeatureNetwork& network) const
{
    return sheet_.levels != nullptr && sheet_.levels->has(network);
}

const GridMask& RenderedPart::grid(const FeatureNetwork& network, const std::string& layer)
{
    return grid_of(data_, network.layer(layer).stride, image_.device());
}

torch::Tensor RenderedPart::feature_mask(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    const auto& mask = grid(network, layer);
    if (pixels == Pixels::steep)
        return mask.all.logical_and(mask.fine.logical_not());
    return pixels == Pixels::all ? mask.all : mask.fine;
}

CroppedLevel* RenderedPart::cropped(const FeatureNetwork& network)
{
    return cropped_level(data_, network, demand(network), image_.device());
}

torch::Tensor RenderedPart::selected_in_crops(CroppedLevel& level, const FeatureNetwork& network, const std::string& layer,
                                              bool camera)
{
    const auto& wanted = camera ? demand(network).camera : demand(network).image;
    std::vector<torch::Tensor> parts;
    std::vector<std::int64_t> fine_counts;
    for (std::size_t i = 0; i < level.crops.size(); ++i)
    {
        // The maps go as soon as they are there: all that losses may read is their level's cells.
        parts.push_back(encoded_layer(
            (camera ? data_.camera_features : features_)[{&network, i}], wanted, layer,
            [&] {
                return encoded_around(network, cut(camera ? data_.camera : image_, level.crops[i].encoded), wanted,
                                      level.pixels[i]);
            },
            [&](const std::string& name, const torch::Tensor& maps)
            { return selected_cells(maps, crop_grid(data_, level, i, network.layer(name).stride, image_.device())); }));
        fine_counts.push_back(crop_grid(data_, level, i, network.layer(layer).stride, image_.device()).fine_count);
    }
    if (parts.empty())
        return at::zeros({network.layer(layer).channels, 0}, image_.options().requires_grad(false));
    return side_by_side(parts, fine_counts);
}

torch::Tensor RenderedPart::selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    auto& all = selected_[{&network, layer}];
    if (is_on_sheet(network))
        all = sheet_.levels->of_level(network, layer, sheet_.number, false);
    else if (auto* level = cropped(network); !all.defined() && level != nullptr)
        all = selected_in_crops(*level, network, layer, false);
    else if (!all.defined())
        all = selected_cells(encoded(features_, network, demand(network).image, layer, image_), grid(network, layer));
    return of_role(all, fine_count(network, layer), pixels);
}

std::int64_t RenderedPart::fine_count(const FeatureNetwork& network, const std::string& layer)
{
    if (is_on_sheet(network))
        return sheet_.levels->fine_count(network, layer, sheet_.number);
    auto* level = cropped(network);
    if (level == nullptr)
        return grid(network, layer).fine_count;
    std::int64_t count = 0;
    for (std::size_t i = 0; i < level->crops.size(); ++i)
        count += crop_grid(data_, *level, i, network.layer(layer).stride, image_.device()).fine_count;
    return count;
}

torch::Tensor RenderedPart::camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    const at::NoGradGuard no_gradient;
    if (is_on_sheet(network))
        return of_role(sheet_.levels->of_level(network, layer, sheet_.number, true), fine_count(network, layer), pixels);
    auto* level = cropped(network);
    const auto all = level != nullptr ? selected_in_crops(*level, network, layer, true)
                                      : selected_cells(whole_camera_features(network, layer), grid(network, layer));
    return of_role(all, fine_count(network, layer), pixels);
}

}  // namespace fresco::optimize
