#include "part.h"

#include <fresco/error.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/upsample_bilinear2d.h>

#include <algorithm>
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

}  // namespace

Demands demands_of(const std::map<std::string, std::shared_ptr<Loss>>& losses)
{
    Demands demands;
    for (const auto& [name, loss] : losses)
        for (const auto& layers : loss->needs().features)
        {
            if (layers.network == nullptr)
                throw Error("loss '" + name + "' needs features but names no network");
            auto& demand = demands[layers.network];
            add_missing(demand.image, layers.names);
            if (layers.camera)
                add_missing(demand.camera, layers.names);
        }
    return demands;
}

RenderedPart::RenderedPart(PartPlace place, torch::Tensor image, LevelData& data, const Demands& demands)
    : place_(place), image_(std::move(image)), data_(data), demands_(demands)
{
}

RenderedPart::~RenderedPart() = default;

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
    if (std::find(wanted.begin(), wanted.end(), layer) == wanted.end())
        throw std::logic_error("a loss asks for the layer '" + layer + "', which its needs() do not name");
    auto& maps = known[&network];
    if (maps.empty())
    {
        const auto result = network.encode(picture, wanted);
        if (result.size() != wanted.size())
            throw std::logic_error("a feature network gave " + std::to_string(result.size()) + " layers for " +
                                   std::to_string(wanted.size()) + " asked for");
        for (std::size_t i = 0; i < wanted.size(); ++i)
            maps.emplace(wanted[i], result[i]);
    }
    return maps.at(layer);
}

torch::Tensor RenderedPart::features(const FeatureNetwork& network, const std::string& layer)
{
    return encoded(features_, network, demand(network).image, layer, image_);
}

torch::Tensor RenderedPart::mask(Pixels pixels)
{
    if (pixels == Pixels::steep)
        return data_.all.logical_and(data_.fine.logical_not());
    return pixels == Pixels::all ? data_.all : data_.fine;
}

torch::Tensor RenderedPart::camera_features(const FeatureNetwork& network, const std::string& layer)
{
    const at::NoGradGuard no_gradient;
    if (data_.smallest)
        return enlarged_camera_features(network, layer);
    return encoded(data_.camera_features, network, demand(network).camera, layer, data_.camera);
}

torch::Tensor RenderedPart::enlarged_camera_features(const FeatureNetwork& network, const std::string& layer)
{
    auto& known = data_.camera_features[&network];
    const auto found = known.find(layer);
    if (found != known.end())
        return found->second;
    const auto small = encoded(data_.smallest->features, network, demand(network).camera, layer, data_.smallest->picture);
    const int stride = network.layer(layer).stride;
    const auto enlarged =
        at::upsample_bilinear2d(small.unsqueeze(0), {image_.size(1) / stride, image_.size(2) / stride}, false).squeeze(0);
    return known.emplace(layer, enlarged).first->second;
}

const GridMask& RenderedPart::grid(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    return grid_of(data_, network.layer(layer).stride, pixels, image_.device());
}

torch::Tensor RenderedPart::feature_mask(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    return grid(network, layer, pixels).cells;
}

torch::Tensor RenderedPart::selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    return selected_cells(features(network, layer), grid(network, layer, pixels));
}

torch::Tensor RenderedPart::camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    const at::NoGradGuard no_gradient;
    return selected_cells(camera_features(network, layer), grid(network, layer, pixels));
}

}  // namespace fresco::optimize
