#include "preparation.h"

#include <fresco/torch/tensor.h>

#include <algorithm>
#include <set>

namespace fresco::optimize
{

std::vector<torch::Tensor> camera_samples(const ViewSource& source, const std::vector<std::size_t>& views,
                                          const torch::Device& device)
{
    constexpr std::size_t most = 8;
    const std::size_t count = std::min(most, views.size());
    std::vector<torch::Tensor> samples;
    for (std::size_t i = 0; i < count; ++i)
    {
        const Raster8 picture = source.camera(views[(2 * i + 1) * views.size() / (2 * count)]);
        const int height = source.height_px(0);
        const int width = Intrinsics{picture.width, picture.height, 1, 1, 0, 0}.width_at(height);
        samples.push_back(to_tensor(resized(picture, width, height)).to(device));
    }
    return samples;
}

void prepare(const std::map<std::string, std::shared_ptr<Loss>>& losses, const PrepareContext& context)
{
    std::set<const FeatureNetwork*> prepared;
    for (const auto& [name, loss] : losses)
        for (const auto& layers : loss->needs().features)
            if (layers.network != nullptr && prepared.insert(layers.network).second)
                layers.network->prepare(context);
    for (const auto& [name, loss] : losses)
        loss->prepare(context);
}

}  // namespace fresco::optimize
