#include "vgg19.h"

#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/features.h>
#include <fresco/weights/state_dict.h>

#include <ATen/ops/adaptive_avg_pool2d.h>
#include <torch/version.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

namespace
{

/// The pictures that weights are rescaled on, with a shorter side of at most 256 pixels: large enough for every layer to see
/// structure, and a few seconds for nine of them.
std::vector<torch::Tensor> rescaling_pictures(const fresco::PrepareContext& context)
{
    constexpr double shorter_px = 256;
    std::vector<torch::Tensor> pictures;
    if (context.style.fine.defined())
        pictures.push_back(context.style.fine);
    pictures.insert(pictures.end(), context.camera_samples.begin(), context.camera_samples.end());
    for (auto& picture : pictures)
    {
        const double factor = shorter_px / static_cast<double>(std::min(picture.size(1), picture.size(2)));
        if (factor < 1)
            picture = at::adaptive_avg_pool2d(picture, {std::llround(static_cast<double>(picture.size(1)) * factor),
                                                        std::llround(static_cast<double>(picture.size(2)) * factor)});
    }
    return pictures;
}

class FeaturesVgg19 final : public fresco::FeatureNetwork, public fresco::PartialFeatures, public fresco::SheetFeatures
{
    fresco::Option<fresco::InputFile> weights{this, "weights", fresco::required, fresco::formats(fresco::weights::file_formats()),
                                              "Weights of VGG-19, or its state dict; may end at any layer"};
    fresco::Option<std::string> convolutions{
        this, "convolutions", "auto", fresco::one_of({"auto", "libtorch"}),
        "auto: minimal filtering for float32 on the CPU (two to three times faster, relative difference about 5e-6), else "
        "libtorch"};
    fresco::Option<std::string> precision{
        this, "precision", "full", fresco::one_of({"full", "tf32"}),
        "Precision of libtorch's convolutions: float32, or TensorFloat-32 (CUDA); features are compared in float32"};

  public:
    void prepare(const fresco::PrepareContext& context) override
    {
        const auto device = context.style.fine.defined() ? context.style.fine.device() : torch::Device(at::kCPU);
        if (*precision == "tf32" && !device.is_cuda())
            throw fresco::Error("features.vgg19: `precision: tf32` is of CUDA devices, and this run is on " + device.str() +
                                "; set `precision: full`");
        bool raw = false;
        network_ = read(raw);
        if (context.style.fine.defined())
            network_.move_to(device);
        if (!raw)
        {
            auto result = vgg19::rescaled(network_, rescaling_pictures(context));
            network_ = std::move(result.network);
            context.message(described(result.means));
        }
        network_.move_to(device);
        network_.set_tf32(*precision == "tf32");
    }

    std::vector<fresco::FeatureLayer> layers() const override { return network_.layers(); }

    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        return encode(picture, names, nullptr);
    }

    std::vector<torch::Tensor> encode_around(const torch::Tensor& picture, const std::vector<std::string>& names,
                                             const fresco::ReadPixels& read) const override
    {
        return encode(picture, names, &read);
    }

    bool takes_sheets() const override { return network_.takes_sheets(); }

    std::vector<torch::Tensor> encode_sheet(const torch::Tensor& picture, const std::vector<std::string>& names,
                                            const fresco::Sheet& sheet) const override
    {
        for (const auto& name : names)
            layer(name);
        return network_.encode_sheet(picture, names, sheet);
    }

  private:
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names,
                                      const fresco::ReadPixels* read) const
    {
        for (const auto& name : names)
            layer(name);
        if (*convolutions == "auto")
            return network_.encode(picture, names, read);
        return network_.encode_generally(picture, names);
    }

    /// Lists the rescaled layers with their means before and after.
    std::string described(const std::vector<double>& means) const
    {
        std::ostringstream text;
        text.precision(3);
        text << "features.vgg19: mean activations rescaled:";
        for (std::size_t i = 0; i < means.size(); ++i)
        {
            const std::string& layer = network_.convolutions()[i].layer;
            text << (i > 0 ? ", " : " ") << layer << ' ' << means[i] << " to " << vgg19::raw_mean(layer);
        }
        return text.str();
    }

    vgg19::Vgg19 read(bool& raw) const
    {
        if (weights->empty())
            throw fresco::MissingInput("features.vgg19: `weights` is empty; set it to a file with VGG-19 weights (`fresco "
                                       "weights get vgg19` downloads torchvision's)");
        const std::string source = weights->path.string();
        const auto file = fresco::weights::read_weights(weights->path);
        const auto found = fresco::weights::recognize_vgg19(file.contents, source);
        raw = found.raw;
        return {vgg19::convolutions(found, source), found.input};
    }

    vgg19::Vgg19 network_;
};

}  // namespace

FRESCO_COMPONENT("features.vgg19", FeaturesVgg19, fresco::FeatureNetwork, "VGG-19 with weights from a file")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
