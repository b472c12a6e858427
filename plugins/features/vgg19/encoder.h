#pragma once

#include "convolution.h"

#include <fresco/torch/features.h>
#include <fresco/weights/vgg19.h>

#include <torch/types.h>

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace vgg19
{

/// One of the 16 convolutions.
struct Convolution
{
    std::string layer;      ///< "relu1_1", its response after the rectifier
    torch::Tensor weights;  ///< K x C x 3 x 3, float32
    torch::Tensor bias;     ///< K
    bool pooled = false;    ///< Comes after a pooling.
};

/// VGG-19 for float32 pictures on the CPU: convolutions by minimal filtering, channels innermost from end to end, and for the
/// way back at most one byte for each response instead of the response. Thread-safe. Equal bytes for any number of threads.
class CpuEncoder : public std::enable_shared_from_this<CpuEncoder>
{
  public:
    CpuEncoder(const std::vector<Convolution>& layers, const fresco::weights::Vgg19Input& input);

    /// Whether it can encode `picture` up to `last`: else the general way has to.
    static bool takes(const torch::Tensor& picture, const std::vector<Convolution>& layers, std::size_t last);

    /// Responses of the convolutions `wanted` (ascending, each once; not empty) to `picture` (3 x H x W, RGB in [0,1]), each
    /// C x floor(H / stride) x floor(W / stride) with the channels innermost in memory. Differentiable once.
    /// With `read`, it computes only what PartialFeatures says.
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::size_t>& wanted,
                                      const fresco::ReadPixels* read = nullptr) const;

  private:
    struct Function;
    struct Tape;
    struct Needed;

    /// Filters are transformed when they are first needed: many runs stop at an early layer, or need no gradient.
    struct Layer
    {
        torch::Tensor weights;
        std::vector<float> bias;  ///< Filled up with zeros.
        bool pooled = false;
        std::once_flag forward_once;
        std::once_flag backward_once;
        std::optional<Convolution3x3> forward;
        std::optional<Convolution3x3> backward;
    };

    const Convolution3x3& forward(std::size_t layer) const;
    const Convolution3x3& backward(std::size_t layer) const;
    torch::Tensor network_input(const torch::Tensor& picture) const;
    torch::Tensor picture_gradient(GradientView gradient, MapsShape shape) const;
    Needed needed(const fresco::ReadPixels& read, const std::vector<std::size_t>& wanted) const;
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, Tape& tape, bool goes_back) const;
    /// Gradient of the layer's own responses, channels innermost; undefined if the layer has none.
    static torch::Tensor own_gradient(const Tape& tape, const std::vector<torch::Tensor>& of_wanted, std::size_t layer);
    torch::Tensor gradient(const Tape& tape, const std::vector<torch::Tensor>& of_wanted) const;

    std::vector<std::unique_ptr<Layer>> layers_;
    fresco::weights::Vgg19Input input_;
};

}  // namespace vgg19
