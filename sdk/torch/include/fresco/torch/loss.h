#pragma once

/// \file What losses that compare features with the style picture do alike. `loss` is the loss's type, named in errors.

#include <fresco/option.h>
#include <fresco/torch/features.h>

#include <torch/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// Subset of a part's pixels (StyleMesh, section 3.3).
enum class Pixels
{
    all,   ///< All that belong to its level.
    fine,  ///< Pixels of `all` that pass the angle filter.
    steep  ///< Pixels of `all` that do not pass it.
};

/// Features that a loss reads: the optimizer encodes no more than these and can cut a frame into crops.
struct LossNeeds
{
    struct Layers
    {
        FeatureNetwork* network = nullptr;  ///< The optimizer prepares it.
        std::vector<std::string> names;
        bool whole = false;   ///< features() as a map C x h x w; else only selected().
        bool camera = false;  ///< Also the same layers of the camera picture.
    };
    std::vector<Layers> features;
    bool picture = false;  ///< Reads image(), camera() or mask(): then the part is the whole frame.
};

/// One rendered level of one step. Made and owned by the optimizer; valid during evaluate. Several losses share it, and each
/// network encodes it once. Tensors are float32 on the run's device; do not change them in place.
class Part
{
  public:
    virtual ~Part();
    virtual int level() const = 0;  ///< Index into the render pyramid, 0 = the smallest height.
    virtual int height_px() const = 0;
    virtual std::int64_t step() const = 0;    ///< Counted from 0 over the run.
    virtual std::int64_t view() const = 0;    ///< Number of the frame.
    virtual std::int64_t repeat() const = 0;  ///< 0 at the first of the consecutive steps on this view.
    virtual std::uint64_t seed() const = 0;   ///< Depends only on run seed, step and level.

    virtual torch::Tensor image() = 0;   ///< RGB in [0,1], 3 x H x W; gradients flow through it. 0 where no pixel is valid.
    virtual torch::Tensor camera() = 0;  ///< The camera picture at this size, RGB in [0,1], 3 x H x W; no gradient.
    virtual torch::Tensor mask(Pixels pixels) = 0;  ///< H x W, bool.

    virtual torch::Tensor features(const FeatureNetwork& network, const std::string& layer) = 0;  ///< C x h x w
    virtual torch::Tensor camera_features(const FeatureNetwork& network,
                                          const std::string& layer) = 0;  ///< C x h x w, no gradient
    /// The mask on a layer's grid (nearest neighbor): h x w, bool.
    virtual torch::Tensor feature_mask(const FeatureNetwork& network, const std::string& layer, Pixels pixels) = 0;
    /// The features inside the mask: C x N, N may be 0. Of Pixels::all the first fine_count() are those of Pixels::fine, and the
    /// others those of Pixels::steep. Within these their order is the optimizer's own, one for the image and the camera: it may
    /// differ from feature_mask's, because large frames are encoded in crops.
    virtual torch::Tensor selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels) = 0;
    virtual torch::Tensor camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels) = 0;
    /// How many features selected(network, layer, Pixels::fine) has.
    virtual std::int64_t fine_count(const FeatureNetwork& network, const std::string& layer) = 0;
};

/// One level's columns of Levels::selected(), and the factor ŵ_l of its term.
struct LevelColumns
{
    std::int64_t count = 0;
    std::int64_t fine_count = 0;  ///< They come first.
    double share = 1;
};

/// All levels of a step with their selected features side by side. Made and owned by the optimizer.
class Levels
{
  public:
    virtual ~Levels();
    /// Part::selected() of all pixels, one level after the other: C x ΣN.
    virtual torch::Tensor selected(const FeatureNetwork& network, const std::string& layer) = 0;
    virtual torch::Tensor camera_selected(const FeatureNetwork& network, const std::string& layer) = 0;
    virtual std::vector<LevelColumns> columns(const FeatureNetwork& network, const std::string& layer) = 0;
    /// Remembers a tensor that depends only on the view, for all steps of a visit.
    virtual const torch::Tensor& kept(const std::string& name, const std::function<torch::Tensor()>& make) = 0;
};

/// A summand of a loss: a scalar tensor, and the network layer it belongs to ("" = none). The optimizer multiplies it by the
/// loss's weight and by the level's share ŵ_l, which may depend on the layer's grid where `network` is given.
struct LossTerm
{
    std::string layer;
    torch::Tensor value;
    const FeatureNetwork* network = nullptr;
};

/// Tensors that a component needs to go on after an interruption, by name.
using TensorMap = std::map<std::string, torch::Tensor>;

/// Penalty on rendered pictures. Depth levels, angle filter, ŵ_l, gradient scaling, schedule and checkpoints are the
/// optimizer's: a loss sees one part at a time and owns none of it. Used by one thread.
class Loss : public Component
{
  public:
    static constexpr std::string_view component_kind = "loss";
    ~Loss() override;

    Option<double> weight{this, "weight", 1.0, at_least(0), "Factor of this loss in the sum"};

    /// Valid from configure() on; networks need not be prepared yet. The names of a network's default layers are known, and
    /// given, only once that network is prepared: the optimizer asks again then.
    virtual LossNeeds needs() const = 0;
    /// Once per run, after every network's prepare.
    virtual void prepare(const PrepareContext& context) = 0;
    /// The terms for one part; none where it has no pixels for this loss. On another device than the CPU the picture may hold
    /// values that are not finite, as the step before is checked later.
    virtual std::vector<LossTerm> evaluate(Part& part) = 0;
    /// State that evaluate keeps from step to step; empty by default.
    virtual TensorMap state() const;
    virtual void restore(const TensorMap& state);
};

/// A second base of losses that can compare all levels at once, in fewer operators than one after the other.
class JointLoss
{
  public:
    virtual ~JointLoss();
    /// As Loss::evaluate() for every level, each term summed over the levels with their shares; nothing: the loss wants parts.
    virtual std::optional<std::vector<LossTerm>> evaluate_together(Levels& levels) = 0;
};

/// A layer that is compared, and the factor of its term.
struct StyleLayer
{
    std::string name;
    double factor = 1;
};
std::vector<std::string> names_of(const std::vector<StyleLayer>& layers);

/// One size of the style picture and the pixels of a part that are compared with it (StyleMesh, section 3.3).
struct StyleRole
{
    Pixels pixels;
    torch::Tensor picture;
};

/// Options that such losses share; a member of the loss.
struct StyleOptions
{
    explicit StyleOptions(Configurable* owner);

    Slot<FeatureNetwork> features;
    Option<std::string> layers;
    Option<std::vector<double>> layer_weights;
    Option<std::string> targets;

    /// The layers named, or the network's own for styles where none are, with their factors; the network is prepared. Throws
    /// Error for unknown layers, a wrong number of factors, a network without layers for styles.
    std::vector<StyleLayer> compared(std::string_view loss) const;
    /// Selected features of `compared`; of the layers named, where it is empty.
    LossNeeds needs(const std::vector<StyleLayer>& compared) const;
    /// The coarse picture on all pixels, the fine one on those that pass the angle filter, as `targets` says.
    std::vector<StyleRole> roles(const StylePictures& style) const;
};

/// The features of `picture` in each of the layers, C x N with N >= 1; no gradient. Throws Error where the picture is too small.
std::vector<torch::Tensor> style_features(const FeatureNetwork& network, const torch::Tensor& picture,
                                          const std::vector<StyleLayer>& layers, std::string_view loss);

}  // namespace fresco
