#include "components.h"
#include "forked_case.h"
#include "method_tables.h"
#include "scene.h"

#include <fresco/torch/tensor.h>
#include <fresco/torch/texture_representation.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>

namespace bench
{
namespace
{

/// Layers and, while autograd works, their gradients and the planes it is given; megabytes.
double needed_mb(int size_px)
{
    return 4.0 / 3 * size_px * size_px * 3 * 4 * 3 / 1e6;
}

torch::Tensor picture_gradient(int height_px)
{
    return fresco::to_tensor(generated_style(height_px * 4 / 3, height_px)) - 0.5;
}

std::shared_ptr<fresco::TextureRepresentation> filled_texture(Components& components, int size_px)
{
    auto texture = components.make<fresco::TextureRepresentation>(fresco::Value::Map{{"type", "texture.laplacian"}});
    texture->allocate(size_px);
    for (auto& parameter : texture->parameters())
        parameter.values.copy_(at::arange(parameter.values.numel(), at::kFloat).mul_(0.7548776662F).frac_().reshape({-1, 3}));
    return texture;
}

/// What autograd does with a pyramid of dense layers: grid_sample on each, and a gradient for every texel.
class DensePyramid
{
  public:
    DensePyramid(const std::vector<fresco::TextureParameter>& parameters, int size_px, const fresco::UvMap& map)
    {
        for (const auto& parameter : parameters)
        {
            auto planes = parameter.values.reshape({size_px, size_px, 3}).permute({2, 0, 1}).contiguous().unsqueeze(0);
            layers_.push_back(planes.set_requires_grad(true));
            size_px /= 2;
        }
        const int width = map.valid.width;
        const int height = map.valid.height;
        grid_ = at::empty({1, height, width, 2}, at::kFloat);
        mask_ = at::empty({1, 1, height, width}, at::kFloat);
        for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        {
            grid_.data_ptr<float>()[2 * i] = 2 * map.uv.values[2 * i] - 1;
            grid_.data_ptr<float>()[2 * i + 1] = 1 - 2 * map.uv.values[2 * i + 1];
            mask_.data_ptr<float>()[i] = map.valid.values[i];
        }
    }

    torch::Tensor render() const
    {
        torch::Tensor sum;
        for (const auto& layer : layers_)
        {
            constexpr int bilinear = 0;
            constexpr int clamped_border = 1;
            const auto seen = at::grid_sampler(layer, grid_, bilinear, clamped_border, false);
            sum = sum.defined() ? sum + seen : seen;
        }
        return (sum * mask_).squeeze(0);
    }

    std::vector<torch::Tensor> gradients(const torch::Tensor& rendered, const torch::Tensor& gradient) const
    {
        return torch::autograd::grad({rendered}, layers_, {gradient});
    }

  private:
    std::vector<torch::Tensor> layers_;
    torch::Tensor grid_;
    torch::Tensor mask_;
};

fresco::Value sparse(int size_px, int height_px, int threads, Measure& measure)
{
    at::set_num_threads(threads);
    Components components;
    const auto texture = filled_texture(components, size_px);
    const auto map = generated_view(height_px);
    const auto gradient = picture_gradient(height_px);
    std::unique_ptr<fresco::TextureView> view;
    const auto step = [&]
    {
        view->render();
        view->gradient(gradient);
    };
    const auto once = measure.times(1, [&] { view = texture->make_view(map); });
    const auto times = measure.times(5, step);
    return fresco::Value::Map{{"ms_once_per_view", 1e3 * once.wall},
                              {"ms_per_step", 1e3 * times.wall},
                              {"processor_ms_per_step", 1e3 * times.processor}};
}

fresco::Value dense(int size_px, int height_px, int threads, Measure& measure)
{
    at::set_num_threads(threads);
    Components components;
    const auto texture = filled_texture(components, size_px);
    const DensePyramid pyramid(texture->parameters(), size_px, generated_view(height_px));
    const auto gradient = picture_gradient(height_px);
    const auto times = measure.times(3, [&] { pyramid.gradients(pyramid.render(), gradient); });
    return fresco::Value::Map{{"ms_per_step", 1e3 * times.wall}, {"processor_ms_per_step", 1e3 * times.processor}};
}

fresco::Value compared(int size_px, int height_px, int threads)
{
    at::set_num_threads(threads);
    Components components;
    const auto texture = filled_texture(components, size_px);
    const auto map = generated_view(height_px);
    const DensePyramid pyramid(texture->parameters(), size_px, map);
    const auto view = texture->make_view(map);
    const auto gradient = picture_gradient(height_px);
    const auto rendered = pyramid.render();
    const double picture = (rendered.detach() - view->render()).abs().max().item<double>();
    const auto dense_gradients = pyramid.gradients(rendered, gradient);
    const auto sparse_gradients = view->gradient(gradient);
    double apart = 0;
    for (std::size_t i = 0; i < dense_gradients.size(); ++i)
    {
        // Texels that the sparse gradient leaves out count as zero.
        auto difference = dense_gradients[i].squeeze(0).permute({1, 2, 0}).reshape({-1, 3}).contiguous();
        difference.index_add_(0, sparse_gradients[i].texels, -sparse_gradients[i].values);
        apart = std::max(apart, difference.abs().max().item<double>());
    }
    return fresco::Value::Map{{"picture_difference", picture}, {"gradient_difference", apart}};
}

void add_rows(Table& table, int size, int height, int threads)
{
    const auto check = run_case([&](Measure&) { return compared(size, height, threads); });
    auto slow = run_case([&](Measure& measure) { return dense(size, height, threads, measure); });
    auto fast = run_case([&](Measure& measure) { return sparse(size, height, threads, measure); });
    slow.set("way", "grid_sample on every layer, dense gradient");
    fast.set("way", "texture.laplacian");
    fast.set("times_faster", ratio(entry(slow, "processor_ms_per_step"), entry(fast, "processor_ms_per_step")));
    for (auto* row : {&slow, &fast})
    {
        row->set("size_px", size);
        row->set("height_px", height);
        for (const char* key : {"picture_difference", "gradient_difference"})
            row->set(key, entry(check, key));
        if (const auto note = entry(check, "note"); note.is_string())
            row->set("note", note);
        table.add(std::move(*row));
    }
}

}  // namespace

Table lookup_table(const MethodSettings& settings)
{
    Table table("lookup", "one view rendered from the texture and its gradient taken back; four layers",
                {{"way", "way"},
                 {"size_px", "size px"},
                 {"height_px", "height px"},
                 {"ms_once_per_view", "ms once per view"},
                 {"ms_per_step", "ms/step"},
                 {"processor_ms_per_step", "cpu ms/step"},
                 {"times_faster", "x faster (cpu)", 1},
                 {"peak_mb", "peak MB", 0},
                 {"picture_difference", "picture apart", 7},
                 {"gradient_difference", "gradient apart", 7}});
    for (const int size : settings.sizes_px)
        for (const int height : settings.heights_px)
        {
            if (1.5 * needed_mb(size) > available_memory_mb())
                table.add(fresco::Value::Map{{"way", "both"},
                                             {"size_px", size},
                                             {"height_px", height},
                                             {"note", "left out: it needs more memory than is free"}});
            else
                add_rows(table, size, height, settings.threads);
        }
    return table;
}

}  // namespace bench
