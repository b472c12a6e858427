#include <fresco/torch/testing.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/ones.h>

namespace fresco::testing
{
namespace
{

/// Pixel under the middle of each of `cells` feature cells.
torch::Tensor middles(std::int64_t cells, int stride)
{
    return at::arange(cells, at::kLong) * stride + stride / 2;
}

torch::Tensor inside(const torch::Tensor& map, const torch::Tensor& mask)
{
    return map.flatten(1).index_select(1, mask.flatten().nonzero().squeeze(1));
}

torch::Tensor whole(const torch::Tensor& picture)
{
    return at::ones({picture.size(1), picture.size(2)}, at::kBool);
}

}  // namespace

PicturePart::PicturePart(const torch::Tensor& picture, const torch::Tensor& camera)
    : picture_(picture), camera_(camera.detach()), mask_(whole(picture)), fine_(whole(picture))
{
}

PicturePart::PicturePart(const torch::Tensor& picture, const torch::Tensor& camera, torch::Tensor mask, torch::Tensor fine)
    : picture_(picture * mask.to(picture.scalar_type())), camera_(camera.detach()), mask_(std::move(mask)), fine_(std::move(fine))
{
}

PicturePart::~PicturePart() = default;

torch::Tensor PicturePart::mask(Pixels pixels)
{
    if (pixels == Pixels::steep)
        return mask_.logical_and(fine_.logical_not());
    return pixels == Pixels::all ? mask_ : fine_;
}

const torch::Tensor& PicturePart::encoded(Encoded& known, const torch::Tensor& picture, const FeatureNetwork& network,
                                          const std::string& layer)
{
    network.layer(layer);
    if (!known.contains({&network, layer}))
    {
        std::vector<std::string> names;
        for (const auto& each : network.layers())
            names.push_back(each.name);
        const auto maps = network.encode(picture, names);
        for (std::size_t i = 0; i < names.size(); ++i)
            known[{&network, names[i]}] = maps[i];
    }
    return known.at({&network, layer});
}

torch::Tensor PicturePart::features(const FeatureNetwork& network, const std::string& layer)
{
    return encoded(features_, picture_, network, layer);
}

torch::Tensor PicturePart::camera_features(const FeatureNetwork& network, const std::string& layer)
{
    const at::NoGradGuard no_gradient;
    return encoded(camera_features_, camera_, network, layer);
}

torch::Tensor PicturePart::feature_mask(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    const int stride = network.layer(layer).stride;
    const auto all = mask(pixels);
    return all.index_select(0, middles(all.size(0) / stride, stride)).index_select(1, middles(all.size(1) / stride, stride));
}

torch::Tensor PicturePart::selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    return inside(features(network, layer), feature_mask(network, layer, pixels));
}

torch::Tensor PicturePart::camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    return inside(camera_features(network, layer), feature_mask(network, layer, pixels));
}

}  // namespace fresco::testing
