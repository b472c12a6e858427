#include "patches.h"
#include "search.h"

#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>

#include <ATen/ATen.h>
#include <torch/version.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace
{

namespace pm = patch_match;

class LossPatchMatch final : public fresco::Loss
{
    /// Sizes at which patches are compared, each half the last: strokes, and what they make up.
    static constexpr int scales = 3;
    /// Distance between neighboring patches: a quarter of all, which overlap enough to hide their grid.
    static constexpr int stride_px = 2;
    /// The search takes longer than a step, and the assignment hardly changes in a few.
    static constexpr int refresh_steps = 8;
    /// Principal components of a patch; the others hold little but noise.
    static constexpr int dimensions = 32;
    /// Per size; the search takes time in proportion, so larger pictures are sampled more coarsely.
    static constexpr int max_style_patches = 24'000;
    /// Below 2, so that a patch may keep a few pixels of its own (Kwatra et al.).
    static constexpr double exponent = 0.8;
    /// In variances of style patches: small enough for all parts of the style to be used (Granot et al.).
    static constexpr double completeness = 0.03;
    fresco::Option<double> guide{this, "guide", 0.5, fresco::at_least(0),
                                 "Weight of the recolored camera picture in the search; 0.2 keeps fewer room edges, 1 more"};

    /// Style patches that the patches of one level are drawn to, per scale; found at `step`.
    struct Matches
    {
        std::int64_t step = 0;
        std::vector<torch::Tensor> nearest;
    };

  public:
    fresco::LossNeeds needs() const override
    {
        fresco::LossNeeds needs;
        needs.picture = true;
        return needs;
    }

    void prepare(const fresco::PrepareContext& context) override
    {
        const at::NoGradGuard no_gradient;
        fresco::ColorMoments camera;
        for (const auto& sample : context.camera_samples)
            camera.add(pm::color_moments(sample));
        map_ = fresco::monge_kantorovich(camera, pm::color_moments(context.style.fine));
        progress_ = context.progress;
        style_.clear();
        auto picture = context.style.fine.to(at::kCPU);
        for (int scale = 0; scale < scales; ++scale, picture = pm::halved(picture))
        {
            if (std::min(picture.size(1), picture.size(2)) < pm::patch_size)
                throw fresco::Error(
                    fmt::format("loss.patch_match: the style picture is {} x {}; expected at least {} pixels a side",
                                context.style.fine.size(2), context.style.fine.size(1), pm::patch_size << (scales - 1)));
            style_.push_back(pm::make_style_patches(picture, max_style_patches, dimensions));
        }
    }

    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        // Patches are searched and compared on the CPU, wherever the run's other losses are.
        auto picture = part.image().to(at::kCPU);
        auto& matches = matches_for(part);
        torch::Tensor sum;
        for (std::size_t scale = 0; scale < style_.size(); ++scale)
        {
            if (scale > 0)
                picture = pm::halved(picture);
            const auto& style = style_[scale];
            const auto value = pm::robust_distance(picture, grid(picture), matches.nearest.at(scale), style.patches,
                                                   std::max(style.total_variance, 1e-6), exponent, progress_->threads());
            if (value.defined())
                sum = sum.defined() ? sum + value : value;
        }
        if (!sum.defined())
            return {};
        return {{"", (sum / static_cast<double>(scales)).to(part.image().device())}};
    }

    fresco::TensorMap state() const override
    {
        fresco::TensorMap state;
        if (matches_.empty())
            return state;
        state["view"] = at::tensor(view_, at::kLong);
        for (const auto& [level, matches] : matches_)
        {
            const auto name = fmt::format("level{}", level);
            state[name + ".step"] = at::tensor(matches.step, at::kLong);
            for (std::size_t scale = 0; scale < matches.nearest.size(); ++scale)
                state[fmt::format("{}.scale{}", name, scale)] = matches.nearest[scale];
        }
        return state;
    }

    void restore(const fresco::TensorMap& state) override
    {
        matches_.clear();
        if (state.empty())
            return;
        view_ = state.at("view").item<std::int64_t>();
        for (int level = 0; level < most_levels; ++level)
        {
            const auto name = fmt::format("level{}", level);
            if (!state.contains(name + ".step"))
                continue;
            Matches matches{state.at(name + ".step").item<std::int64_t>(), {}};
            for (int scale = 0; scale < scales; ++scale)
                matches.nearest.push_back(state.at(fmt::format("{}.scale{}", name, scale)));
            matches_[level] = std::move(matches);
        }
    }

  private:
    static constexpr int most_levels = 64;  ///< More than any render pyramid has.

    pm::PatchGrid grid(const torch::Tensor& picture) const { return {picture.size(2), picture.size(1), stride_px}; }

    /// Only the current view's matches are kept. Asked again within a step, the same ones serve.
    Matches& matches_for(fresco::Part& part)
    {
        if (part.view() != view_)
            matches_.clear();
        view_ = part.view();
        const auto found = matches_.find(part.level());
        const bool due = part.repeat() % refresh_steps == 0;
        if (found != matches_.end() && (!due || found->second.step == part.step()))
            return found->second;
        return matches_[part.level()] = search(part);
    }

    Matches search(fresco::Part& part) const
    {
        const at::NoGradGuard no_gradient;
        auto picture = part.image().detach().to(at::kCPU);
        auto guide_picture = pm::recolored(part.camera().to(at::kCPU), map_);
        auto mask = part.mask(fresco::Pixels::all).to(at::kCPU);
        Matches matches{part.step(), {}};
        for (std::size_t scale = 0; scale < style_.size(); ++scale)
        {
            if (scale > 0)
            {
                picture = pm::halved(picture);
                guide_picture = pm::halved(guide_picture);
                mask = pm::halved_mask(mask);
            }
            const auto patches = grid(picture);
            auto nearest = at::full({patches.count()}, -1, at::kInt);
            const auto rows = pm::whole_patches(mask, patches).nonzero().squeeze(1);
            if (rows.numel() > 0)
            {
                const auto& style = style_[scale];
                const auto found = pm::nearest_patches(
                    {.patches = pm::project(style, pm::extract_patches(picture, patches).index_select(0, rows)),
                     .guide = pm::project(style, pm::extract_patches(guide_picture, patches).index_select(0, rows)),
                     .style = style.keys,
                     .guide_weight = *guide,
                     .tolerance = completeness * std::max(style.total_variance, 1e-6)},
                    *progress_);
                nearest.index_copy_(0, rows, found);
            }
            matches.nearest.push_back(nearest);
        }
        return matches;
    }

    fresco::ColorMap map_;
    fresco::Progress* progress_ = nullptr;
    std::vector<pm::StylePatches> style_;
    std::map<int, Matches> matches_;
    std::int64_t view_ = -1;
};

}  // namespace

FRESCO_COMPONENT("loss.patch_match", LossPatchMatch, fresco::Loss,
                 "Pulls each patch toward its nearest style patch: brush strokes without a network")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
