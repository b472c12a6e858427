#pragma once

#include <fresco/image.h>

#include <torch/types.h>

#include <string>
#include <vector>

namespace fresco
{

/// What a feature network may be besides: one that leaves out work nobody reads. A level of a view often has few of the frame's
/// pixels, while the features of these see as many again around them.
class PartialFeatures
{
  public:
    virtual ~PartialFeatures();

    /// \see FeatureNetwork::encode, where of `pixels` (H x W, 0 = no) only this is read: the features of cells that hold one, and
    /// the picture's gradient there. Everything else is finite where that is, and else arbitrary.
    virtual std::vector<torch::Tensor> encode_around(const torch::Tensor& picture, const std::vector<std::string>& layers,
                                                     const Raster8& pixels) const = 0;
};

}  // namespace fresco
