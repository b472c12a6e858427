#include "low_pass.h"

#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/recolour.h>

#include <ATen/ATen.h>
#include <torch/version.h>

#include <algorithm>
#include <map>

namespace
{

namespace cg = content_gradients;

// Cells of 2, 4 and 8 pixels for edges; colours only where strokes are averaged away.
constexpr int edge_cells[] = {2, 4, 8};
constexpr int colour_cells[] = {4, 8};

class LossContentGradients final : public fresco::Loss
{
    fresco::Option<double> edges{this, "edges", 1.0, fresco::at_least(0), "Factor of the luminance gradients"};
    fresco::Option<double> colour{this, "colour", 1.0, fresco::at_least(0), "Factor of the low-pass colours"};

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
            camera.add(fresco::color_moments(sample));
        const auto style = fresco::color_moments(context.style.fine);
        map_ = fresco::monge_kantorovich(camera, style);
        const auto covariance = style.covariance();
        colour_scale_ = std::max((covariance(0, 0) + covariance(1, 1) + covariance(2, 2)) / 3, smallest_scale);
        for (const int size : edge_cells)
            edge_scale_[size] = mean_edge(context.camera_samples, size);
    }

    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        const auto image = part.image();
        const auto mask = part.mask(fresco::Pixels::all);
        const auto target = fresco::recoloured(part.camera().to(image.scalar_type()), map_);
        torch::Tensor sum;
        const auto add = [&](const torch::Tensor& value, double factor)
        {
            if (value.defined() && factor > 0)
                sum = sum.defined() ? sum + value * factor : value * factor;
        };
        const auto image_luminance = cg::luminance(image);
        const auto target_luminance = cg::luminance(target);
        for (const int size : edge_cells)
            add(cg::step_difference(cg::low_pass(image_luminance, mask, size), cg::low_pass(target_luminance, mask, size)),
                *edges / (edge_scale_.at(size) * static_cast<double>(std::size(edge_cells))));
        for (const int size : colour_cells)
            add(cg::value_difference(cg::low_pass(image, mask, size), cg::low_pass(target, mask, size)),
                *colour / (colour_scale_ * static_cast<double>(std::size(colour_cells))));
        if (!sum.defined())
            return {};
        return {{"", sum}};
    }

  private:
    // A deviation of 0.01 in [0,1] colours: flatter pictures must not make the loss explode.
    static constexpr double smallest_scale = 1e-4;

    /// Mean square luminance step between cells of the recoloured samples: the unit of the edge terms.
    double mean_edge(const std::vector<torch::Tensor>& samples, int size) const
    {
        double sum = 0;
        int count = 0;
        for (const auto& sample : samples)
        {
            const auto mask = at::ones({sample.size(1), sample.size(2)}, sample.options().dtype(at::kBool));
            const auto cells = cg::low_pass(cg::luminance(fresco::recoloured(sample, map_)), mask, size);
            const auto value = cg::step_difference(cells, {at::zeros_like(cells.values), cells.valid});
            if (!value.defined())
                continue;
            sum += value.item<double>();
            ++count;
        }
        return std::max(count > 0 ? sum / count : 0.0, smallest_scale);
    }

    fresco::ColorMap map_;
    double colour_scale_ = 1;
    std::map<int, double> edge_scale_;
};

}  // namespace

FRESCO_COMPONENT("loss.content_gradients", LossContentGradients, fresco::Loss,
                 "Edges and broad colours of the camera picture, recoloured to the style; no network needed")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
