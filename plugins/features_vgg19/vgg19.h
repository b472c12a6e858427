#pragma once

#include <fresco/torch/features.h>
#include <fresco/weights/vgg19.h>

#include <torch/types.h>

#include <string>
#include <string_view>
#include <vector>

namespace vgg19
{

enum class Pooling
{
    max,
    average
};

/// One of the 16 convolutions.
struct Convolution
{
    std::string layer;      ///< "relu1_1", its response after the rectifier
    torch::Tensor weights;  ///< K x C x 3 x 3, float32
    torch::Tensor bias;     ///< K
    bool pooled = false;    ///< Comes after a pooling.
};

/// The layers of a file as tensors of their own. Throws fresco::Error naming `source` and the tensor for values that are not
/// finite.
std::vector<Convolution> convolutions(const fresco::weights::Vgg19Weights& weights, std::string_view source);

/// VGG-19 without its classifier (Simonyan and Zisserman, 2015). Frozen; encode is thread-safe.
class Vgg19
{
  public:
    Vgg19() = default;
    Vgg19(std::vector<Convolution> layers, const fresco::weights::Vgg19Input& input, Pooling pooling);

    std::vector<fresco::FeatureLayer> layers() const;
    /// Named layers of `picture` (RGB in [0,1], 3 x H x W, float32 or float64), each C x floor(H / stride) x floor(W / stride).
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const;
    /// Call it before encode, which takes weights that are elsewhere over each time.
    void move_to(const torch::Device& device);
    const fresco::weights::Vgg19Input& input() const { return input_; }
    const std::vector<Convolution>& convolutions() const { return convolutions_; }
    Pooling pooling() const { return pooling_; }

  private:
    torch::Tensor network_input(const torch::Tensor& picture) const;

    std::vector<Convolution> convolutions_;
    fresco::weights::Vgg19Input input_;
    Pooling pooling_ = Pooling::max;
};

}  // namespace vgg19
