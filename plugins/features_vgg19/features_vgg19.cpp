#include "vgg19.h"

#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/features.h>

#include <torch/version.h>

namespace
{

class FeaturesVgg19 final : public fresco::FeatureNetwork
{
    fresco::Option<fresco::InputFile> weights{this, "weights", fresco::required,
                                              "Weights of VGG-19 as safetensors; may end at any layer"};
    fresco::Option<std::string> pooling{this, "pooling", "max", fresco::one_of({"max", "average"}), "How 2x2 cells are joined"};
    fresco::Option<std::string> padding{this, "padding", "auto", fresco::one_of({"auto", "zero", "reflect"}),
                                        "What lies beyond the border; auto: as the weights say"};

  public:
    void prepare(const fresco::PrepareContext&) override
    {
        if (weights->empty())
            throw fresco::MissingInput("features.vgg19: `weights` is empty; give a safetensors file with the weights of VGG-19");
        const auto contents = fresco::read_safetensors(weights->path);
        auto format = vgg19::input_format(contents, weights->path);
        if (*padding != "auto")
            format.padding = *padding == "zero" ? vgg19::Padding::zero : vgg19::Padding::reflect;
        network_ = vgg19::Vgg19(vgg19::convolutions(contents, weights->path), format,
                                *pooling == "max" ? vgg19::Pooling::max : vgg19::Pooling::average);
    }

    std::vector<fresco::FeatureLayer> layers() const override { return network_.layers(); }

    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        for (const auto& name : names)
            layer(name);
        return network_.encode(picture, names);
    }

  private:
    vgg19::Vgg19 network_;
};

}  // namespace

FRESCO_COMPONENT("features.vgg19", FeaturesVgg19, fresco::FeatureNetwork, "VGG-19 with weights from a safetensors file")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
