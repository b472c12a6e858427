#pragma once

#include <fresco/progress.h>
#include <fresco/torch/features.h>

#include <torch/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace dictionary
{

/// How a dictionary is learned.
struct LearnOptions
{
    int patches = 20'000;  ///< Per layer, half from the picture and half from its noisy copy.
    double noise = 0.25;   ///< Standard deviation of the copy's noise, in [0,1] colours.
    double epsilon = 0.1;  ///< Floor of the whitening, in mean eigenvalues.
    int iterations = 12;   ///< Rounds of k-means.
    std::uint64_t seed = 0;
};

/// One convolution: response = relu(filters * x + bias).
struct Layer
{
    torch::Tensor filters;  ///< K x C x s x s, float32
    torch::Tensor bias;     ///< K
};

/// Features learned from one picture, without any network: per layer, patches are whitened and grouped by direction; each group
/// is a filter whose response is centred and scaled to unit deviation, and kept where positive. Layers are joined by 2x2
/// averages.
class Dictionary
{
  public:
    /// Learns from `picture` (RGB in [0,1], 3 x H x W, both at least 64), on the CPU. Deterministic for any thread count. Throws
    /// fresco::Error for a smaller picture, fresco::Cancelled.
    static Dictionary learn(const torch::Tensor& picture, const LearnOptions& options, fresco::Progress& progress);

    /// Of what encode is given, before it is called.
    void move_to(const torch::Device& device);

    /// Layers "d1" … "d4": 67 (64 filters and RGB), 96, 128, 128 channels; strides 1, 2, 4, 8.
    static std::vector<fresco::FeatureLayer> layers();

    /// The first `count` layers of `picture` (3 x H x W, float32 or float64), each C x floor(H / stride) x floor(W / stride);
    /// borders are reflected. Where a picture is too small for a layer, h or w is 0.
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, std::size_t count) const;

    const std::vector<Layer>& filters() const { return layers_; }

  private:
    std::vector<Layer> layers_;
};

}  // namespace dictionary
