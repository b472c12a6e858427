#pragma once

#include <fresco/component.h>
#include <fresco/image.h>
#include <fresco/parallel.h>

#include <torch/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// The style picture as losses see it: RGB in [0,1], float32, 3 x H x W (StyleMesh, section 3.3).
struct StylePictures
{
    torch::Tensor fine;    ///< Shorter side 256 px (or the original's, if smaller).
    torch::Tensor coarse;  ///< Up to four times as large, at most the original's size.
};

/// Inputs of a component before the first step.
struct PrepareContext
{
    StylePictures style;
    std::vector<torch::Tensor> camera_samples;  ///< A few camera pictures, RGB in [0,1], 3 x H x W, spread over the run.
    std::uint64_t seed = 0;
    Progress* progress = nullptr;                                                 ///< Never null; lives as long as the run.
    std::function<void(const std::string&)> message = [](const std::string&) {};  ///< Tells the person who runs it.
};

/// One layer of a feature network.
struct FeatureLayer
{
    std::string name;  ///< "relu1_1"
    int channels = 0;
    int stride = 1;        ///< Pixels per feature cell; cell (i, j) looks at pixels around ((i + 0.5) stride, (j + 0.5) stride).
    int margin_px = 0;     ///< Pixels beyond its own cell that a feature sees.
    bool style = false;    ///< Its statistics describe a style: taken where a loss names no layers.
    bool content = false;  ///< Its values describe what is seen: taken where a loss names no layers. One layer at most.
};

/// Turns a picture into features. Frozen once prepared: encode is differentiable in the picture, thread-safe, and deterministic.
class FeatureNetwork : public Component
{
  public:
    static constexpr std::string_view component_kind = "features";
    ~FeatureNetwork() override;

    /// Loads weights or learns from the style. Called once per run, before everything else.
    virtual void prepare(const PrepareContext& context) = 0;
    /// The layers it has, in order; valid after prepare.
    virtual std::vector<FeatureLayer> layers() const = 0;
    /// Features of `picture` (RGB in [0,1], float32 or float64, 3 x H x W) for the named layers, in that order, each C x h x w
    /// with h = floor(H / stride). The network applies its own channel order, mean and scale. Throws Error naming an unknown
    /// layer.
    virtual std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& layers) const = 0;

    /// The description of a layer. Throws Error naming the layers there are.
    FeatureLayer layer(const std::string& name) const;
};

/// Pixels of a picture, H x W each; 0 = no.
struct ReadPixels
{
    Raster8 features;
    Raster8 gradient;
};

/// A second base of feature networks that can skip work whose results nobody reads. A level of a view often has few of the
/// frame's pixels, and a network that knows them computes only what their features depend on.
class PartialFeatures
{
  public:
    virtual ~PartialFeatures();

    /// \see FeatureNetwork::encode, where only features of cells with a pixel in `read.features` are read, and the picture's
    /// gradient only at the pixels in `read.gradient`. All other values are arbitrary, but finite if these are.
    virtual std::vector<torch::Tensor> encode_around(const torch::Tensor& picture, const std::vector<std::string>& layers,
                                                     const ReadPixels& read) const = 0;
};

/// Pixels of one picture, gathered into boxes of a sheet that lie apart: the levels of a view, or parts of them. Positions are
/// row-major numbers, int64, on the picture's device.
struct Sheet
{
    std::int64_t height = 0;  ///< Like the boxes' corners, multiples of every stride.
    std::int64_t width = 0;
    torch::Tensor pixels;                  ///< n: pixels of the picture …
    torch::Tensor places;                  ///< … and where each lies in the sheet; the rest belongs to no box.
    std::map<int, torch::Tensor> borders;  ///< By stride: the cells next to a box, which belong to no box.
    std::map<int, torch::Tensor> cells;    ///< By stride: the cells of boxes whose features are wanted, each once.
};

/// A second base of feature networks that can encode all boxes of a sheet at once, as if each were a picture of its own: on a
/// graphics card, sending operators takes longer than what they do for one small picture.
class SheetFeatures
{
  public:
    virtual ~SheetFeatures();

    /// False, for example, for weights that pad pictures with anything but zeros.
    virtual bool takes_sheets() const = 0;
    /// The features of each layer at the sheet's cells of its stride, C x N; differentiable in `picture` (3 x H x W).
    virtual std::vector<torch::Tensor> encode_sheet(const torch::Tensor& picture, const std::vector<std::string>& layers,
                                                    const Sheet& sheet) const = 0;
};

/// The names in a list such as "relu1_1, relu2_1": separated by commas or blanks, in order, each once.
std::vector<std::string> split_layer_names(std::string_view list);

}  // namespace fresco
