#include <fresco/torch/testing.h>

#include <fresco/testing.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/avg_pool2d.h>
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

/// The cells of `map` (C x h x w) in `mask`, those in `first` before the others.
torch::Tensor inside(const torch::Tensor& map, const torch::Tensor& mask, const torch::Tensor& first)
{
    const auto numbers = [](const torch::Tensor& cells) { return cells.flatten().nonzero().squeeze(1); };
    const auto others = mask.logical_and(first.logical_not());
    return map.flatten(1).index_select(1, at::cat({numbers(mask.logical_and(first)), numbers(others)}));
}

torch::Tensor whole(const torch::Tensor& picture)
{
    return at::ones({picture.size(1), picture.size(2)}, at::kBool);
}

}  // namespace

void ColorNetwork::prepare(const PrepareContext&) {}

std::vector<FeatureLayer> ColorNetwork::layers() const
{
    return {{.name = "a", .channels = 3, .style = true}, {.name = "b", .channels = 3, .stride = 2, .content = true}};
}

std::vector<torch::Tensor> ColorNetwork::encode(const torch::Tensor& picture, const std::vector<std::string>& layers) const
{
    std::vector<torch::Tensor> maps;
    for (const auto& name : layers)
    {
        if (layer(name).stride == 1)
            maps.push_back(picture);
        else if (picture.size(1) < 2 || picture.size(2) < 2)
            maps.push_back(picture.new_zeros({3, picture.size(1) / 2, picture.size(2) / 2}));
        else
            maps.push_back(at::avg_pool2d(picture.unsqueeze(0), {2, 2}).squeeze(0));
    }
    return maps;
}

std::unique_ptr<Loss> loss_on_colors(const std::filesystem::path& library, const std::string& type, const std::string& options)
{
    TestFactory factory;
    factory.add("test.colors", [] { return std::make_shared<ColorNetwork>(); });
    auto value = parse_json(options, "test");
    value.set("features", Value::Map{{"type", "test.colors"}});
    auto loss = make_from_plugin<Loss>(library, type);
    loss->configure(value, factory);
    return loss;
}

PicturePart::PicturePart(const torch::Tensor& picture, const torch::Tensor& camera)
    : picture_(picture), camera_(camera.detach()), mask_(whole(picture)), fine_(whole(picture))
{
}

PicturePart::PicturePart(const torch::Tensor& picture, const torch::Tensor& camera, torch::Tensor mask, torch::Tensor fine)
    : picture_(picture * mask.to(picture.scalar_type())), camera_(camera.detach()), mask_(std::move(mask)), fine_(std::move(fine))
{
}

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
    return inside(features(network, layer), feature_mask(network, layer, pixels), feature_mask(network, layer, Pixels::fine));
}

std::int64_t PicturePart::fine_count(const FeatureNetwork& network, const std::string& layer)
{
    return feature_mask(network, layer, Pixels::fine).sum().item<std::int64_t>();
}

torch::Tensor PicturePart::camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    return inside(camera_features(network, layer), feature_mask(network, layer, pixels),
                  feature_mask(network, layer, Pixels::fine));
}

}  // namespace fresco::testing
