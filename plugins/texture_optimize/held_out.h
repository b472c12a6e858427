#pragma once

#include "evaluation.h"
#include "view_data.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace fresco::optimize
{

/// Splits the views, in recorded order, into those to optimize for and `count` evenly spread ones to measure on. Throws Error
/// where that leaves none to optimize for.
struct ViewSplit
{
    std::vector<std::size_t> trained;
    std::vector<std::size_t> held_out;
};
ViewSplit split_views(const std::vector<std::size_t>& views, int count);

/// A loss measured on the held-out views after some steps.
struct HeldOutLoss
{
    std::int64_t step = 0;
    double loss = 0;
    std::vector<double> parts;  ///< Of each loss, in the order of their names; their sum is `loss`.
    /// Since the stage began, without the measuring; not known of measurements before an interruption, and in no checkpoint.
    std::optional<double> seconds{};
};

/// Whether the last `window` measurements are worth nothing: their smallest is not below (1 - gain) times the smallest before.
bool has_stopped_falling(const std::vector<HeldOutLoss>& history, double gain, std::size_t window = 3);

/// What the losses, without the texture's regularizer, say of views that are not optimized for: the mean over these views. One
/// view is in memory at a time. Used by one thread; references its arguments.
class HeldOutViews
{
  public:
    HeldOutViews(const ViewSource& source, const std::vector<std::size_t>& views, const TextureRepresentation& texture,
                 const LevelRules& rules, const torch::Device& device, bool texture_too);

    /// Every view is measured with the losses' present state and with the draws of step 0, so that measurements differ
    /// only by the texture; the state is left as it was. Throws Canceled between two views.
    HeldOutLoss measured(Evaluator& evaluator, std::int64_t step, const std::map<std::string, std::shared_ptr<Loss>>& losses,
                         const Progress& progress);

  private:
    const ViewSource& source_;
    const std::vector<std::size_t>& views_;
    const TextureRepresentation& texture_;
    const LevelRules& rules_;
    torch::Device device_;
    bool texture_too_;
};

}  // namespace fresco::optimize
