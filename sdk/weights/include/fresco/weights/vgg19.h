#pragma once

#include <fresco/weights/state_dict.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

/// \file The weights of VGG-19 (Simonyan and Zisserman, 2015) in a state dict, and what they expect of their input.

namespace fresco::weights
{

enum class Vgg19Padding
{
    zero,
    reflect
};

/// Input format of the weights: channels in their order, scale · RGB in [0,1], minus the mean, divided by the
/// deviation.
struct Vgg19Input
{
    bool bgr = false;                          ///< Channel order; else RGB.
    double scale = 1;                          ///< Factor of RGB in [0,1].
    std::array<double, 3> mean{};              ///< In the network's channel order and scale.
    std::array<double, 3> deviation{1, 1, 1};  ///< In the network's channel order.
    Vgg19Padding padding = Vgg19Padding::zero;
};
/// BGR in 0..255 minus (103.939, 116.779, 123.68), zero padding: Simonyan and Zisserman's own weights, as Caffe has them.
Vgg19Input caffe_input();
/// RGB in [0,1], ImageNet mean and deviation, zero padding: torchvision's weights.
Vgg19Input torchvision_input();
/// "BGR in 0..255 minus (103.939, 116.779, 123.68)" or "RGB in [0,1], ImageNet mean and deviation": what the metadata says.
std::string_view input_text(const Vgg19Input& input);
/// "zero" or "reflect".
std::string_view padding_text(Vgg19Padding padding);

/// One of the 16 convolutions.
struct Vgg19Layer
{
    std::string name;     ///< "1_1", of conv1_1 and relu1_1
    TensorView weight;    ///< K x C x 3 x 3
    TensorView bias;      ///< K
    bool pooled = false;  ///< Comes after a pooling.
};

enum class Vgg19Keys
{
    torchvision,  ///< "features.0.weight"
    caffe         ///< "conv1_1.weight"
};

struct Vgg19Weights
{
    Vgg19Keys keys = Vgg19Keys::torchvision;
    Vgg19Input input;
    bool raw = false;                  ///< Activations as Simonyan and Zisserman's own: the scale that StyleMesh's λ is for.
    std::vector<Vgg19Layer> layers;    ///< From conv1_1 on, without a gap; at least one.
    std::vector<std::string> ignored;  ///< Tensors of the classifier.
};

/// Finds the layers by torchvision's or Caffe's names, as far as they go, and checks every name, shape and type. What the
/// metadata of a safetensors file says ("input", "padding", "scale") decides; without it torchvision's names mean torchvision's
/// input and scale, Caffe's names Caffe's input and raw activations, as in Gatys' vgg_conv.pth. Throws Error naming `source` and
/// the tensor or the entry that is wrong.
Vgg19Weights recognize_vgg19(const StateDict& contents, std::string_view source);

/// The metadata that says what `weights` says of itself.
std::map<std::string, std::string> vgg19_metadata(const Vgg19Weights& weights);

}  // namespace fresco::weights
