#include "rendered_part.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/cat.h>
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

/// `layer` of the picture; all `wanted` layers are encoded together when the first is asked for, and of each stays what `kept`
/// makes of it, where given.
torch::Tensor
encoded_layer(std::map<std::string, torch::Tensor>& known, const FeatureNetwork& network, const std::vector<std::string>& wanted,
              const std::string& layer, const torch::Tensor& picture,
              const std::function<torch::Tensor(const std::string& layer, const torch::Tensor& maps)>& kept = nullptr)
{
    if (std::find(wanted.begin(), wanted.end(), layer) == wanted.end())
        throw std::logic_error("a loss asks for the layer '" + layer + "', which its needs() do not name");
    if (known.empty())
    {
        auto result = network.encode(picture, wanted);
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

torch::Tensor cut(const torch::Tensor& picture, const PixelBox& box)
{
    return picture.slice(1, box.y0, box.y1).slice(2, box.x0, box.x1);
}

/// C x N tensors -> C x (sum of N), in memory as they are.
torch::Tensor side_by_side(std::vector<torch::Tensor>& parts)
{
    if (parts.size() == 1)
        return parts[0];
    if (parts[0].is_contiguous())
        return at::cat(parts, 1);
    for (auto& part : parts)
        part = part.t();
    return at::cat(parts, 0).t();
}

/// The mask of the crop's core, as large as what is encoded.
Raster8 core_mask(const Raster8& mask, const Crop& crop)
{
    Raster8 result(crop.encoded.x1 - crop.encoded.x0, crop.encoded.y1 - crop.encoded.y0);
    for (int y = crop.core.y0; y < crop.core.y1; ++y)
        for (int x = crop.core.x0; x < crop.core.x1; ++x)
            result.at(x - crop.encoded.x0, y - crop.encoded.y0) = mask.at(x, y);
    return result;
}

torch::Tensor numbers_on(const std::vector<std::int64_t>& numbers, const torch::Device& device)
{
    auto tensor = at::empty({std::ssize(numbers)}, at::kLong);
    std::copy(numbers.begin(), numbers.end(), tensor.data_ptr<std::int64_t>());
    return sent_to(tensor, device);
}

/// Which of the cells chosen so far are fine: by the processor, which knows the masks.
class FineNumbers
{
  public:
    /// More cells: `fine` are some of `all`, both ascending.
    void add(std::span<const std::int64_t> all, std::span<const std::int64_t> fine)
    {
        auto next = fine.begin();
        for (const auto cell : all)
        {
            const bool is_fine = next != fine.end() && *next == cell;
            (is_fine ? fine_ : others_).push_back(count_++);
            next += is_fine ? 1 : 0;
        }
    }
    FineColumns on(const torch::Device& device) const { return {numbers_on(fine_, device), numbers_on(others_, device)}; }

  private:
    std::vector<std::int64_t> fine_;
    std::vector<std::int64_t> others_;
    std::int64_t count_ = 0;
};

}  // namespace

Demands demands_of(const std::map<std::string, std::shared_ptr<Loss>>& losses, bool crops)
{
    Demands demands;
    for (const auto& [name, loss] : losses)
        for (const auto& layers : loss->needs().features)
        {
            if (layers.network == nullptr)
                throw Error("loss '" + name + "' needs features but names no network");
            auto& demand = demands[layers.network];
            demand.whole = demand.whole || layers.whole || !crops;
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
    return encoded_layer(known[&network], network, wanted, layer, picture);
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

CroppedLevel* RenderedPart::cropped(const FeatureNetwork& network)
{
    // Enlarged camera features have no crops, and both must select in one order.
    if (demand(network).whole || data_.smallest)
        return nullptr;
    auto found = data_.cropped.find(&network);
    if (found == data_.cropped.end())
    {
        int align = 1;
        int margin = 0;
        for (const auto& name : demand(network).image)
        {
            const auto layer = network.layer(name);
            align = std::lcm(align, layer.stride);
            margin = std::max(margin, layer.margin_px);
        }
        CroppedLevel level{covering_crops(data_.pixels.all, align, margin), {}, {}};
        level.camera_features.resize(level.crops.size());
        level.grids.resize(level.crops.size());
        found = data_.cropped.emplace(&network, std::move(level)).first;
    }
    return &found->second;
}

const GridMask& RenderedPart::crop_grid(CroppedLevel& level, std::size_t number, int stride, Pixels pixels)
{
    auto& known = level.grids[number];
    const auto found = known.find({stride, pixels});
    if (found != known.end())
        return found->second;
    const auto mask = core_mask(chosen_pixels(data_.pixels, pixels), level.crops[number]);
    return known.emplace(std::tuple(stride, pixels), grid_mask(mask, stride, Protocol::paper, image_.device())).first->second;
}

torch::Tensor RenderedPart::selected_in_crops(CroppedLevel& level, const FeatureNetwork& network, const std::string& layer,
                                              Pixels pixels, bool camera)
{
    const auto& wanted = camera ? demand(network).camera : demand(network).image;
    auto& image_features = crop_features_[&network];
    image_features.resize(level.crops.size());
    const int stride = network.layer(layer).stride;
    std::vector<torch::Tensor> parts;
    for (std::size_t i = 0; i < level.crops.size(); ++i)
    {
        // The maps go as soon as they are there: all that losses may read is their level's cells.
        const auto all =
            encoded_layer(camera ? level.camera_features[i] : image_features[i], network, wanted, layer,
                          cut(camera ? data_.camera : image_, level.crops[i].encoded),
                          [&](const std::string& name, const torch::Tensor& maps)
                          { return selected_cells(maps, crop_grid(level, i, network.layer(name).stride, Pixels::all)); });
        parts.push_back(pixels == Pixels::all
                            ? all
                            : selected_among(all, crop_grid(level, i, stride, Pixels::all), crop_grid(level, i, stride, pixels)));
    }
    if (parts.empty())
        return at::zeros({network.layer(layer).channels, 0}, image_.options().requires_grad(false));
    return side_by_side(parts);
}

torch::Tensor RenderedPart::selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    if (auto* level = cropped(network))
        return selected_in_crops(*level, network, layer, pixels, false);
    return selected_cells(encoded(features_, network, demand(network).image, layer, image_), grid(network, layer, pixels));
}

FineColumns RenderedPart::fine_among_selected(const FeatureNetwork& network, const std::string& layer)
{
    const int stride = network.layer(layer).stride;
    const auto key = std::pair(&network, stride);
    if (const auto found = data_.fine_columns.find(key); found != data_.fine_columns.end())
        return found->second;
    FineNumbers numbers;
    if (auto* level = cropped(network))
        for (std::size_t i = 0; i < level->crops.size(); ++i)
            numbers.add(crop_grid(*level, i, stride, Pixels::all).numbers(),
                        crop_grid(*level, i, stride, Pixels::fine).numbers());
    else
        numbers.add(grid(network, layer, Pixels::all).numbers(), grid(network, layer, Pixels::fine).numbers());
    return data_.fine_columns.emplace(key, numbers.on(image_.device())).first->second;
}

torch::Tensor RenderedPart::camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels)
{
    const at::NoGradGuard no_gradient;
    if (auto* level = cropped(network))
        return selected_in_crops(*level, network, layer, pixels, true);
    return selected_cells(whole_camera_features(network, layer), grid(network, layer, pixels));
}

}  // namespace fresco::optimize
