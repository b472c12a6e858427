#pragma once

/// \file VGG-19 from its weights to features. Also brings weights to the scale of Simonyan and Zisserman's own activations, as
/// StyleMesh's λ hold only for these: a Gram loss grows with the fourth power of the activations, a content loss with the second.

#include "encoder.h"

#include <fresco/torch/features.h>
#include <fresco/weights/vgg19.h>

#include <torch/types.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace vgg19
{

/// The layers of a file as tensors of their own. Throws fresco::Error naming `source` and the tensor for values that are not
/// finite.
std::vector<Convolution> convolutions(const fresco::weights::Vgg19Weights& weights, std::string_view source);

/// VGG-19 without its classifier (Simonyan and Zisserman, 2015). Frozen; encode is thread-safe.
class Vgg19
{
  public:
    Vgg19() = default;
    Vgg19(std::vector<Convolution> layers, const fresco::weights::Vgg19Input& input);

    std::vector<fresco::FeatureLayer> layers() const;
    /// Named layers of `picture` (RGB in [0,1], 3 x H x W, float32 or float64), each C x floor(H / stride) x floor(W / stride).
    /// Float32 pictures on the CPU take the fast way.
    /// With `read`, it computes only what PartialFeatures says.
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names,
                                      const fresco::ReadPixels* read = nullptr) const;
    /// encode() by libtorch's convolutions, on any device and in float64 too.
    std::vector<torch::Tensor> encode_generally(const torch::Tensor& picture, const std::vector<std::string>& names) const;
    /// \see fresco::SheetFeatures. On any device, by libtorch's convolutions.
    bool takes_sheets() const { return input_.padding == fresco::weights::Vgg19Padding::zero; }
    std::vector<torch::Tensor> encode_sheet(const torch::Tensor& picture, const std::vector<std::string>& names,
                                            const fresco::Sheet& sheet) const;
    /// Call it before encode, which takes weights that are elsewhere over each time.
    void move_to(const torch::Device& device);
    /// Whether encode_generally rounds the factors of float32 products to ten bits behind the point (TensorFloat-32, on CUDA
    /// only); keeps a second copy of the weights.
    void set_tf32(bool tf32);
    const fresco::weights::Vgg19Input& input() const { return input_; }
    const std::vector<Convolution>& convolutions() const { return convolutions_; }

  private:
    struct SheetTape;
    struct SheetFunction;
    torch::Tensor network_input(const torch::Tensor& picture) const;
    /// Rectified responses of layer `number` to maps of 1 x C x H x W.
    torch::Tensor responses(std::size_t number, const torch::Tensor& maps) const;

    /// As libtorch convolves with them: channels innermost.
    struct Filters
    {
        torch::Tensor weights;
        torch::Tensor turned;  ///< For the way back.
        torch::Tensor bias;
    };
    void get_ready();
    /// Makes the filters of a layer, unless get_ready() has.
    Filters filters(std::size_t number, const torch::TensorOptions& options) const;

    /// The network's input is offset + factor · picture, each 3 x 1 x 1.
    struct InputTerms
    {
        torch::Tensor factor;
        torch::Tensor offset;
    };

    InputTerms input_terms_;  ///< In float32, on the network's device.
    InputTerms exact_input_terms_;
    std::vector<Convolution> convolutions_;
    std::vector<Filters> ready_;  ///< On the network's device and in its precision; empty: they are made each time.
    bool tf32_ = false;
    std::shared_ptr<const CpuEncoder> on_cpu_;
    fresco::weights::Vgg19Input input_;
};

/// The raw network's mean activation in a layer such as "relu3_1". Layers without a known figure take that of the closest earlier
/// layer that has one.
double raw_mean(std::string_view layer);

struct Rescaled
{
    Vgg19 network;
    std::vector<double> means;  ///< Before, per layer.
};

/// `network` with every layer scaled to the raw network's mean over `pictures`, and with an input of BGR in 0..255 minus the mean
/// color, so that a border of zeros stays the mean color. Throws fresco::Error if a layer is silent on all
/// pictures or there are no pictures.
Rescaled rescaled(const Vgg19& network, const std::vector<torch::Tensor>& pictures);

}  // namespace vgg19
