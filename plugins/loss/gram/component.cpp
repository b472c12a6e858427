#include "gram_matrix.h"

#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/tensor.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros_like.h>
#include <torch/version.h>

#include <algorithm>
#include <fmt/format.h>
#include <initializer_list>
#include <optional>

namespace
{

class LossGram final : public fresco::Loss, public fresco::JointLoss
{
    fresco::StyleOptions style{this};
    fresco::Option<std::string> rule{
        this, "rule", "printed", fresco::one_of({"printed", "released"}),
        "printed: coarse target on all pixels together; released: separately on those that pass and fail the angle filter, and "
        "the fine target only on relu4_1 and relu5_1 where these are compared"};
    fresco::Option<int> average_views_count{this, "average_views_count", 1, fresco::range(1, 1000),
                                            "Number of recent views whose Gram matrices are averaged"};

    struct Targets
    {
        std::optional<torch::Tensor> coarse;
        std::optional<torch::Tensor> fine;
        torch::Tensor both;  ///< Side by side, if there is a coarse one.
    };

  public:
    fresco::LossNeeds needs() const override { return style.needs(compared_); }

    void prepare(const fresco::PrepareContext& context) override
    {
        const at::NoGradGuard no_gradient;
        compared_ = style.compared(type);
        if (*rule == "released" && *style.targets == "fine")
            throw fresco::Error("loss.gram: `rule: released` needs the coarse target; set `targets` to coarse or both");
        average_ = gram::ViewAverage(*average_views_count);
        targets_.assign(compared_.size(), {});
        for (const auto& role : style.roles(context.style))
        {
            const bool fine = role.pixels == fresco::Pixels::fine;
            const auto features = fresco::style_features(*style.features, role.picture, compared_, type);
            for (std::size_t i = 0; i < features.size(); ++i)
                if (!fine || has_fine(compared_[i].name))
                    (fine ? targets_[i].fine : targets_[i].coarse) = gram::gram_matrix(features[i]);
        }
        for (auto& [coarse, fine, both] : targets_)
            if (coarse)
                both = fine ? at::stack({*coarse, *fine}) : coarse->unsqueeze(0);
    }

    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        std::vector<fresco::LossTerm> terms;
        for (std::size_t i = 0; i < compared_.size(); ++i)
        {
            const auto& targets = targets_[i];
            const bool apart = targets.coarse && *rule == "released";
            if (is_plain())
            {
                add_plain(terms, part, i);
                continue;
            }
            torch::Tensor sum;
            if (apart)
                add_apart(sum, part, i);
            else if (targets.coarse)
                add_together(sum, part, i);
            else if (const auto fine = part.selected(*style.features, compared_[i].name, fresco::Pixels::fine); fine.size(1) > 0)
                add(sum, averaged(gram::gram_matrix(fine), part, compared_[i].name, fresco::Pixels::fine), {&*targets.fine});
            if (sum.defined())
                terms.push_back({compared_[i].name, sum * compared_[i].factor, &*style.features});
        }
        return terms;
    }

    std::optional<std::vector<fresco::LossTerm>> evaluate_together(fresco::Levels& levels) override
    {
        if (!is_plain())
            return std::nullopt;
        std::vector<fresco::LossTerm> terms;
        for (std::size_t i = 0; i < compared_.size(); ++i)
        {
            const auto& name = compared_[i].name;
            const auto columns = levels.columns(*style.features, name);
            const auto selected = levels.selected(*style.features, name);
            if (selected.size(1) == 0)
                continue;
            const auto& weights = levels.kept(
                fmt::format("{} weights {}", fmt::ptr(this), i),
                [&] { return fresco::sent_to(weights_of(i, columns, selected).to(selected.scalar_type()), selected.device()); });
            terms.push_back({name, gram::gram_distance(selected, columns, targets_[i].both, weights), &*style.features});
        }
        return terms;
    }

    fresco::TensorMap state() const override { return average_.state(); }
    void restore(const fresco::TensorMap& state) override { average_.restore(state); }

  private:
    static constexpr std::string_view type = "loss.gram";

    /// Gram matrices of one view, the coarse target on all pixels together.
    bool is_plain() const { return *style.targets != "fine" && *rule == "printed" && *average_views_count == 1; }

    /// The released code compares the fine target only in its last two layers.
    bool has_fine(const std::string& layer) const
    {
        const auto is_last = [](const std::string& name) { return name == "relu4_1" || name == "relu5_1"; };
        return *rule == "printed" || is_last(layer) || std::ranges::none_of(compared_, is_last, &fresco::StyleLayer::name);
    }

    torch::Tensor weights_of(std::size_t layer, const std::vector<fresco::LevelColumns>& columns,
                             const torch::Tensor& features) const
    {
        const auto elements = static_cast<double>(features.size(0) * features.size(0));
        return gram::gram_weights(columns, targets_[layer].fine.has_value(), compared_[layer].factor / elements);
    }

    void add_plain(std::vector<fresco::LossTerm>& terms, fresco::Part& part, std::size_t layer)
    {
        const auto& name = compared_[layer].name;
        const auto selected = part.selected(*style.features, name, fresco::Pixels::all);
        if (selected.size(1) == 0)
            return;
        const std::vector<fresco::LevelColumns> columns{{selected.size(1), part.fine_count(*style.features, name), 1}};
        const auto weights = fresco::sent_to(weights_of(layer, columns, selected).to(selected.scalar_type()), selected.device());
        terms.push_back({name, gram::gram_distance(selected, columns, targets_[layer].both, weights), &*style.features});
    }

    /// Adds the distances of all features to the coarse target and, if there is a fine one, of the fine ones to that.
    void add_together(torch::Tensor& sum, fresco::Part& part, std::size_t layer)
    {
        const auto& name = compared_[layer].name;
        const auto& targets = targets_[layer];
        const auto selected = part.selected(*style.features, name, fresco::Pixels::all);
        if (selected.size(1) == 0)
            return;
        const auto fine_count = targets.fine ? part.fine_count(*style.features, name) : 0;
        const auto both = gram::gram_of_both(selected, fine_count);
        add(sum, averaged(both.all, part, name, fresco::Pixels::all), {&*targets.coarse});
        if (both.fine)
            add(sum, averaged(*both.fine, part, name, fresco::Pixels::fine), {&*targets.fine});
    }

    torch::Tensor averaged(const torch::Tensor& matrix, fresco::Part& part, const std::string& name, fresco::Pixels pixels)
    {
        if (*average_views_count == 1)
            return matrix;
        return average_.average(fmt::format("level{}.{}.{}", part.level(), name, word(pixels)),
                                {part.step(), part.view(), part.repeat()}, matrix);
    }

    /// Adds the distances of the fine features to both targets, and of the others to the coarse one, as the released code does.
    void add_apart(torch::Tensor& sum, fresco::Part& part, std::size_t layer)
    {
        const auto& name = compared_[layer].name;
        const auto& coarse = *targets_[layer].coarse;
        const auto& fine = targets_[layer].fine;
        const auto selected = part.selected(*style.features, name, fresco::Pixels::all);
        const auto fine_count = part.fine_count(*style.features, name);
        const auto matrix = [&](std::int64_t first, std::int64_t count, fresco::Pixels pixels)
        { return averaged(gram::gram_matrix(selected.narrow(1, first, count)), part, name, pixels); };
        // Without fine features zeros are compared: a constant of the reported loss.
        add(sum, fine_count > 0 ? matrix(0, fine_count, fresco::Pixels::fine) : at::zeros_like(coarse),
            {&coarse, fine ? &*fine : nullptr});
        if (fine_count < selected.size(1))
            add(sum, matrix(fine_count, selected.size(1) - fine_count, fresco::Pixels::steep), {&coarse});
    }

    /// Adds the distances of a matrix to targets (null: none).
    static void add(torch::Tensor& sum, const torch::Tensor& matrix, std::initializer_list<const torch::Tensor*> targets)
    {
        for (const auto* target : targets)
        {
            if (target == nullptr)
                continue;
            const auto value = gram::mean_square_difference(matrix, *target);
            sum = sum.defined() ? sum + value : value;
        }
    }

    static const char* word(fresco::Pixels pixels)
    {
        return pixels == fresco::Pixels::all ? "all" : pixels == fresco::Pixels::fine ? "fine" : "steep";
    }

    std::vector<fresco::StyleLayer> compared_;
    std::vector<Targets> targets_;
    gram::ViewAverage average_{1};
};

}  // namespace

FRESCO_COMPONENT("loss.gram", LossGram, fresco::Loss, "Style as the Gram matrices of features")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
