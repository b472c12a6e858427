#include "view_part.h"

#include <ATen/ATen.h>

#include <algorithm>

namespace bench
{

torch::Tensor Encoded::layer(const fresco::FeatureNetwork& network, const std::vector<std::string>& wanted,
                             const std::string& name, const torch::Tensor& picture)
{
    auto& maps = maps_[&network];
    if (maps.empty())
    {
        const auto encoded = network.encode(picture, wanted);
        for (std::size_t i = 0; i < wanted.size(); ++i)
            maps.emplace(wanted[i], encoded[i]);
    }
    return maps.at(name);
}

Wanted wanted_layers(const std::vector<std::shared_ptr<fresco::Loss>>& losses)
{
    Wanted wanted;
    for (const auto& loss : losses)
        for (const auto& layers : loss->needs().features)
            for (const auto& name : layers.names)
                if (auto& names = wanted[layers.network]; std::find(names.begin(), names.end(), name) == names.end())
                    names.push_back(name);
    return wanted;
}

ViewPart::ViewPart(torch::Tensor image, const torch::Tensor& camera, Encoded& camera_features, const Wanted& wanted,
                   std::int64_t step)
    : image_(std::move(image)), camera_(camera), kept_(camera_features), wanted_(wanted), step_(step)
{
}

ViewPart::~ViewPart() = default;

torch::Tensor ViewPart::mask(fresco::Pixels)
{
    return at::ones({image_.size(1), image_.size(2)}, at::kBool);
}

torch::Tensor ViewPart::features(const fresco::FeatureNetwork& network, const std::string& layer)
{
    return features_.layer(network, wanted_.at(&network), layer, image_);
}

torch::Tensor ViewPart::camera_features(const fresco::FeatureNetwork& network, const std::string& layer)
{
    const at::NoGradGuard no_gradient;
    return kept_.layer(network, wanted_.at(&network), layer, camera_);
}

torch::Tensor ViewPart::feature_mask(const fresco::FeatureNetwork& network, const std::string& layer, fresco::Pixels)
{
    const auto stride = network.layer(layer).stride;
    return at::ones({image_.size(1) / stride, image_.size(2) / stride}, at::kBool);
}

torch::Tensor ViewPart::selected(const fresco::FeatureNetwork& network, const std::string& layer, fresco::Pixels)
{
    return features(network, layer).flatten(1);
}

torch::Tensor ViewPart::camera_selected(const fresco::FeatureNetwork& network, const std::string& layer, fresco::Pixels)
{
    return camera_features(network, layer).flatten(1);
}

fresco::FineColumns ViewPart::fine_among_selected(const fresco::FeatureNetwork& network, const std::string& layer)
{
    const auto count = feature_mask(network, layer, fresco::Pixels::fine).numel();
    return {at::arange(count, at::kLong), at::empty({0}, at::kLong)};
}

}  // namespace bench
