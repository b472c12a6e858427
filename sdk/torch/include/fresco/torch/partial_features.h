#pragma once

#include <fresco/image.h>

#include <torch/types.h>

#include <string>
#include <vector>

namespace fresco
{

/// Pixels of a picture, H x W each; 0 = no.
struct ReadPixels
{
    Raster8 features;
    Raster8 gradient;
};

/// What a feature network may be besides: one that leaves out work nobody reads. A level of a view often has few of the frame's
/// pixels, while the features of these see as many again around them.
class PartialFeatures
{
  public:
    virtual ~PartialFeatures();

    /// \see FeatureNetwork::encode, where only features of cells with a pixel in `read.features` are read, and the picture's
    /// gradient only at the pixels in `read.gradient`. All other values are arbitrary, but finite if these are.
    virtual std::vector<torch::Tensor> encode_around(const torch::Tensor& picture, const std::vector<std::string>& layers,
                                                     const ReadPixels& read) const = 0;
};

}  // namespace fresco
