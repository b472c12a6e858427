#include "grid_mask.h"

#include <fresco/parallel.h>
#include <fresco/torch/tensor.h>

#include <ATen/Parallel.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/empty_strided.h>
#include <ATen/ops/zeros.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace fresco::optimize
{
namespace
{

/// Whether the channels of a pixel lie side by side.
bool has_pixels_in_rows(const at::Tensor& values)
{
    return values.size(0) > 1 && values.size(1) > 1 && values.t().is_contiguous();
}

/// Whether pixels are copied as rows here: as the networks on the CPU give them.
bool has_plain_rows(const at::Tensor& values)
{
    return values.device().is_cpu() && values.scalar_type() == at::kFloat && has_pixels_in_rows(values);
}

/// C x P to C x N by column number; in memory as `values` is. The first `fine_count` numbers ascend, and so do the others; none
/// comes twice.
struct Columns : torch::autograd::Function<Columns>
{
    static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& values, const at::Tensor& index,
                              std::int64_t fine_count)
    {
        context->save_for_backward({index});
        context->saved_data["columns"] = values.size(1);
        context->saved_data["fine_count"] = fine_count;
        if (has_plain_rows(values))
            return pixels(values, index);
        return has_pixels_in_rows(values) ? values.t().index_select(0, index).t() : values.index_select(1, index);
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto index = context->get_saved_variables()[0];
        const auto columns = context->saved_data["columns"].toInt();
        const auto fine_count = context->saved_data["fine_count"].toInt();
        const auto& gradient = gradients[0];
        return {has_plain_rows(gradient) ? spread_pixels(gradient, index, fine_count, columns) : spread(gradient, index, columns),
                at::Tensor(), at::Tensor()};
    }

  private:
    static at::Tensor spread(const at::Tensor& gradient, const at::Tensor& index, std::int64_t columns)
    {
        const auto channels = gradient.size(0);
        if (has_pixels_in_rows(gradient))
            return at::zeros({columns, channels}, gradient.options()).index_copy_(0, index, gradient.t()).t();
        return at::zeros({channels, columns}, gradient.options()).index_copy_(1, index, gradient);
    }
    static at::Tensor pixels(const at::Tensor& values, const at::Tensor& index)
    {
        const auto channels = values.size(0);
        auto result = at::empty_strided({channels, index.numel()}, {1, channels}, values.options());
        const float* from = values.data_ptr<float>();
        float* to = result.data_ptr<float>();
        const auto* numbers = index.data_ptr<std::int64_t>();
        parallel_for(static_cast<std::size_t>(index.numel()), grain(channels), at::get_num_threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         for (auto i = static_cast<std::int64_t>(begin); i < static_cast<std::int64_t>(end); ++i)
                             std::copy_n(from + numbers[i] * channels, channels, to + i * channels);
                     });
        return result;
    }
    static at::Tensor spread_pixels(const at::Tensor& gradient, const at::Tensor& index, std::int64_t fine_count,
                                    std::int64_t columns)
    {
        const auto channels = gradient.size(0);
        auto result = at::empty_strided({channels, columns}, {1, channels}, gradient.options());
        const float* from = gradient.data_ptr<float>();
        float* to = result.data_ptr<float>();
        const auto* numbers = index.data_ptr<std::int64_t>();
        const std::array runs{std::span(numbers, static_cast<std::size_t>(fine_count)),
                              std::span(numbers + fine_count, static_cast<std::size_t>(index.numel() - fine_count))};
        parallel_for(static_cast<std::size_t>(columns), grain(channels), at::get_num_threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         std::array<std::span<const std::int64_t>::iterator, 2> next{};
                         for (std::size_t run = 0; run < 2; ++run)
                             next[run] = std::ranges::lower_bound(runs[run], static_cast<std::int64_t>(begin));
                         for (auto column = static_cast<std::int64_t>(begin); column < static_cast<std::int64_t>(end); ++column)
                         {
                             const std::size_t run = next[0] != runs[0].end() && *next[0] == column ? 0 : 1;
                             if (next[run] == runs[run].end() || *next[run] != column)
                             {
                                 std::fill_n(to + column * channels, channels, 0.0F);
                                 continue;
                             }
                             std::copy_n(from + (&*next[run] - numbers) * channels, channels, to + column * channels);
                             ++next[run];
                         }
                     });
        return result;
    }

    /// Rows of so many values to a piece that one is worth a thread.
    static std::size_t grain(std::int64_t columns)
    {
        return static_cast<std::size_t>(1 + (std::int64_t{1} << 18U) / (columns + 1));
    }
};

}  // namespace

GridMask grid_mask(const Raster8& all, const Raster8& fine, int stride, Protocol protocol, const torch::Device& device)
{
    const int rows = all.height / stride;
    const int columns = all.width / stride;
    const auto pixel = [&](int cell, int cells, int pixels)
    { return is_released(protocol) ? corner_pixel(cell, cells, pixels) : cell * stride + stride / 2; };
    const auto all_cells = at::zeros({rows, columns}, at::kBool);
    const auto fine_cells = at::zeros({rows, columns}, at::kBool);
    std::vector<std::int64_t> chosen;
    std::vector<std::int64_t> others;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
        {
            const int x = pixel(column, columns, all.width);
            const int y = pixel(row, rows, all.height);
            if (all.at(x, y) == 0)
                continue;
            const std::int64_t number = std::int64_t{row} * columns + column;
            const bool is_fine = fine.at(x, y) != 0;
            all_cells.data_ptr<bool>()[number] = true;
            fine_cells.data_ptr<bool>()[number] = is_fine;
            (is_fine ? chosen : others).push_back(number);
        }
    const std::int64_t fine_count = std::ssize(chosen);
    chosen.insert(chosen.end(), others.begin(), others.end());
    auto index = at::empty({std::ssize(chosen)}, at::kLong);
    std::copy(chosen.begin(), chosen.end(), index.data_ptr<std::int64_t>());
    return {sent_to(all_cells, device), sent_to(fine_cells, device), sent_to(index, device), fine_count};
}

torch::Tensor selected_cells(const torch::Tensor& features, const GridMask& mask)
{
    const auto columns = features.reshape({features.size(0), features.size(1) * features.size(2)});
    const auto count = mask.chosen_count();
    if (count == columns.size(1) && (mask.fine_count == 0 || mask.fine_count == count))
        return columns;
    return Columns::apply(columns, mask.index, mask.fine_count);
}

torch::Tensor side_by_side(const std::vector<torch::Tensor>& selected, const std::vector<std::int64_t>& fine_counts)
{
    if (selected.size() == 1)
        return selected[0];
    const bool turned = !selected[0].is_contiguous();
    const std::int64_t side = turned ? 0 : 1;
    std::vector<torch::Tensor> fine;
    std::vector<torch::Tensor> others;
    for (std::size_t i = 0; i < selected.size(); ++i)
    {
        const auto values = turned ? selected[i].t() : selected[i];
        const auto halves = values.split_with_sizes({fine_counts[i], values.size(side) - fine_counts[i]}, side);
        fine.push_back(halves[0]);
        others.push_back(halves[1]);
    }
    fine.insert(fine.end(), others.begin(), others.end());
    const auto all = at::cat(fine, side);
    return turned ? all.t() : all;
}

}  // namespace fresco::optimize
