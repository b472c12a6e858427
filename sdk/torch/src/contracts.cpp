// Destructors and defaults of the tensor contracts: their type information lives in this library.
#include <fresco/torch/features.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/texture_representation.h>

#include <fresco/error.h>

namespace fresco
{

FeatureNetwork::~FeatureNetwork() = default;
Part::~Part() = default;
Loss::~Loss() = default;
TextureView::~TextureView() = default;
TextureRepresentation::~TextureRepresentation() = default;
OptimizerRule::~OptimizerRule() = default;

FeatureLayer FeatureNetwork::layer(const std::string& name) const
{
    std::string known;
    for (const auto& candidate : layers())
    {
        if (candidate.name == name)
            return candidate;
        known += (known.empty() ? "" : ", ") + candidate.name;
    }
    throw Error("the feature network has no layer '" + name + "'; it has: " + known);
}

bool TextureRepresentation::move_to(const torch::Device& device)
{
    return device.is_cpu();
}

bool OptimizerRule::runs_on(const torch::Device& device) const
{
    return device.is_cpu();
}

TensorMap Loss::state() const
{
    return {};
}

void Loss::restore(const TensorMap& state)
{
    if (!state.empty())
        throw Error("the checkpoint holds '" + state.begin()->first +
                    "' for a loss that remembers nothing; remove the checkpoint folder");
}

}  // namespace fresco
