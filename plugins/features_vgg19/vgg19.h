#pragma once

#include <fresco/torch/features.h>
#include <fresco/torch/tensor.h>

#include <torch/types.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vgg19
{

enum class Pooling
{
    max,
    average
};

enum class Padding
{
    zero,
    reflect
};

/// What the weights expect of their input.
struct InputFormat
{
    bool bgr = false;                          ///< Channel order; else RGB.
    double scale = 1;                          ///< Input = scale · RGB in [0,1], then …
    std::array<double, 3> mean{};              ///< … minus the mean, in the network's channel order, …
    std::array<double, 3> deviation{1, 1, 1};  ///< … divided by the deviation.
    Padding padding = Padding::zero;
};

/// BGR in 0..255 minus (103.939, 116.779, 123.68): Gatys' weights and Caffe's.
InputFormat caffe_input();
/// RGB in [0,1], ImageNet mean and deviation, zero padding: torchvision's weights.
InputFormat torchvision_input();

/// What the file says of itself in its metadata ("input", "padding") decides; without that torchvision's keys
/// ("features.N.weight") mean torchvision's input and Gatys' keys ("conv1_1.weight") mean Caffe's with reflected borders. Throws
/// fresco::Error naming `file` for an entry that is not understood.
InputFormat input_format(const fresco::SafeTensors& contents, const std::filesystem::path& file);

/// One of the 16 convolutions.
struct Convolution
{
    std::string layer;      ///< "relu1_1", its response after the rectifier
    torch::Tensor weights;  ///< K x C x 3 x 3, float32
    torch::Tensor bias;     ///< K
    bool pooled = false;    ///< Comes after a pooling.
};

/// The convolutions from conv1_1 on, as far as the file holds them without a gap, under torchvision's keys or Gatys'. Shapes and
/// types are checked against VGG-19. Throws fresco::Error naming file and tensor for a wrong shape or type, a weight without its
/// bias, a gap, or when conv1_1 is missing.
std::vector<Convolution> convolutions(const fresco::SafeTensors& contents, const std::filesystem::path& file);

/// VGG-19 without its classifier (Simonyan and Zisserman, 2015). Frozen; encode is thread-safe.
class Vgg19
{
  public:
    Vgg19() = default;
    Vgg19(std::vector<Convolution> layers, InputFormat format, Pooling pooling);

    std::vector<fresco::FeatureLayer> layers() const;
    /// Named layers of `picture` (RGB in [0,1], 3 x H x W, float32 or float64), each C x floor(H / stride) x floor(W / stride).
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const;
    const InputFormat& format() const { return format_; }

  private:
    torch::Tensor network_input(const torch::Tensor& picture) const;

    std::vector<Convolution> convolutions_;
    InputFormat format_;
    Pooling pooling_ = Pooling::max;
};

}  // namespace vgg19
