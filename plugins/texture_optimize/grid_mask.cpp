#include "grid_mask.h"

#include <fresco/parallel.h>
#include <fresco/torch/tensor.h>

#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/empty_strided.h>
#include <ATen/ops/zeros.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace fresco::optimize
{
namespace
{

bool is_plain(const at::Tensor& tensor)
{
    return tensor.device().is_cpu() && tensor.scalar_type() == at::kFloat;
}

/// Whether the channels of a pixel lie side by side.
bool has_pixels_in_rows(const at::Tensor& values)
{
    return values.size(0) > 1 && values.size(1) > 1 && values.t().is_contiguous();
}

/// C x P to C x N by column number, each number at most once; in memory as `values` is.
struct Columns : torch::autograd::Function<Columns>
{
    static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& values, const at::Tensor& index)
    {
        context->save_for_backward({index});
        context->saved_data["columns"] = values.size(1);
        if (!is_plain(values))
            return has_pixels_in_rows(values) ? values.t().index_select(0, index).t() : values.index_select(1, index);
        if (has_pixels_in_rows(values))
            return pixels(values, index);
        const auto source = values.contiguous();
        auto result = at::empty({source.size(0), index.numel()}, source.options());
        each_row(
            source.size(0), index.numel(),
            [&](std::int64_t row)
            { gather(source.data_ptr<float>() + row * source.size(1), index, result.data_ptr<float>() + row * index.numel()); });
        return result;
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto index = context->get_saved_variables()[0];
        const auto columns = context->saved_data["columns"].toInt();
        if (is_plain(gradients[0]) && has_pixels_in_rows(gradients[0]))
            return {spread_pixels(gradients[0], index, columns), at::Tensor()};
        if (!is_plain(gradients[0]))
            return {spread(gradients[0], index, columns), at::Tensor()};
        const auto gradient = gradients[0].contiguous();
        auto result = at::zeros({gradient.size(0), columns}, gradient.options());
        each_row(gradient.size(0), index.numel(),
                 [&](std::int64_t row)
                 { scatter(gradient.data_ptr<float>() + row * index.numel(), index, result.data_ptr<float>() + row * columns); });
        return {result, at::Tensor()};
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
        each_row(index.numel(), channels,
                 [&](std::int64_t i) { std::copy_n(from + numbers[i] * channels, channels, to + i * channels); });
        return result;
    }
    static at::Tensor spread_pixels(const at::Tensor& gradient, const at::Tensor& index, std::int64_t columns)
    {
        const auto channels = gradient.size(0);
        auto result = at::empty_strided({channels, columns}, {1, channels}, gradient.options());
        const float* from = gradient.data_ptr<float>();
        float* to = result.data_ptr<float>();
        const auto* numbers = index.data_ptr<std::int64_t>();
        const std::int64_t count = index.numel();
        // The numbers ascend: all cells between two of them are zero.
        each_row(count + 1, channels,
                 [&](std::int64_t i)
                 {
                     const std::int64_t before = i == 0 ? 0 : numbers[i - 1] + 1;
                     const std::int64_t here = i == count ? columns : numbers[i];
                     std::fill(to + before * channels, to + here * channels, 0.0F);
                     if (i < count)
                         std::copy_n(from + i * channels, channels, to + here * channels);
                 });
        return result;
    }

    /// Several rows to a piece, so that one is worth a thread.
    template <class Work>
    static void each_row(std::int64_t rows, std::int64_t columns, const Work& work)
    {
        const auto grain = static_cast<std::size_t>(1 + (std::int64_t{1} << 18U) / (columns + 1));
        parallel_for(static_cast<std::size_t>(rows), grain, at::get_num_threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         for (std::size_t row = begin; row < end; ++row)
                             work(static_cast<std::int64_t>(row));
                     });
    }
    static void gather(const float* row, const at::Tensor& index, float* out)
    {
        const auto* columns = index.data_ptr<std::int64_t>();
        for (std::int64_t i = 0; i < index.numel(); ++i)
            out[i] = row[columns[i]];
    }
    static void scatter(const float* values, const at::Tensor& index, float* row)
    {
        const auto* columns = index.data_ptr<std::int64_t>();
        for (std::int64_t i = 0; i < index.numel(); ++i)
            row[columns[i]] = values[i];
    }
};

}  // namespace

std::span<const std::int64_t> GridMask::numbers() const
{
    if (!index.device().is_cpu())
        return near;
    return {index.data_ptr<std::int64_t>(), static_cast<std::size_t>(index.numel())};
}

GridMask grid_mask(const Raster8& mask, int stride, Protocol protocol, const torch::Device& device)
{
    const int rows = mask.height / stride;
    const int columns = mask.width / stride;
    const auto pixel = [&](int cell, int cells, int pixels)
    { return is_released(protocol) ? corner_pixel(cell, cells, pixels) : cell * stride + stride / 2; };
    const auto cells = at::zeros({rows, columns}, at::kBool);
    std::vector<std::int64_t> chosen;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
        {
            if (mask.at(pixel(column, columns, mask.width), pixel(row, rows, mask.height)) == 0)
                continue;
            const std::int64_t number = std::int64_t{row} * columns + column;
            cells.data_ptr<bool>()[number] = true;
            chosen.push_back(number);
        }
    auto index = at::empty({static_cast<std::int64_t>(chosen.size())}, at::kLong);
    std::copy(chosen.begin(), chosen.end(), index.data_ptr<std::int64_t>());
    if (device.is_cpu())
        return {cells, index, {}};
    return {sent_to(cells, device), sent_to(index, device), std::move(chosen)};
}

torch::Tensor selected_cells(const torch::Tensor& features, const GridMask& mask)
{
    const auto columns = features.reshape({features.size(0), features.size(1) * features.size(2)});
    if (mask.index.numel() == columns.size(1))
        return columns;
    return Columns::apply(columns, mask.index);
}

torch::Tensor selected_among(const torch::Tensor& selected, const GridMask& all, const GridMask& part)
{
    const auto wanted = part.numbers();
    if (static_cast<std::int64_t>(wanted.size()) == selected.size(1))
        return selected;
    auto index = at::empty({std::ssize(wanted)}, at::kLong);
    auto* place = index.data_ptr<std::int64_t>();
    std::int64_t column = 0;
    auto next = wanted.begin();
    for (const auto cell : all.numbers())
    {
        if (next != wanted.end() && *next == cell)
        {
            *place++ = column;
            ++next;
        }
        ++column;
    }
    return Columns::apply(selected, sent_to(index, selected.device()));
}

}  // namespace fresco::optimize
