#include <fresco/torch/tensor.h>

#include <fresco/parallel.h>

#include <ATen/Dispatch.h>
#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

namespace fresco
{
namespace
{

constexpr std::int64_t chunk_length = 16384;

/// The sum of up to `chunk_length` values in double precision: eight interleaved partial sums, added from the first to the last.
template <class T>
double chunk_sum(const T* values, std::int64_t count)
{
    std::array<double, 8> lanes{};
    std::int64_t i = 0;
    for (; i + 8 <= count; i += 8)
        for (std::size_t lane = 0; lane < 8; ++lane)
            lanes[lane] += static_cast<double>(values[i + static_cast<std::int64_t>(lane)]);
    for (std::size_t lane = 0; i < count; ++i, ++lane)
        lanes[lane] += static_cast<double>(values[i]);
    double sum = 0;
    for (const double lane : lanes)
        sum += lane;
    return sum;
}

/// Sums of the rows of a contiguous R x N tensor. The chunks never depend on the threads; only who adds them up does.
template <class T>
void row_sums(const T* values, std::int64_t rows, std::int64_t columns, T* sums)
{
    const std::int64_t per_row = std::max<std::int64_t>(1, (columns + chunk_length - 1) / chunk_length);
    std::vector<double> partial(static_cast<std::size_t>(rows * per_row));
    // Not at::parallel_for: outside libtorch it is serial unless every caller is compiled with OpenMP. A piece takes about 0.2
    // ms.
    const std::int64_t grain =
        std::max<std::int64_t>(1, 32 * chunk_length / std::max<std::int64_t>(1, std::min(columns, chunk_length)));
    parallel_for(partial.size(), static_cast<std::size_t>(grain), at::get_num_threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t piece = begin; piece < end; ++piece)
                     {
                         const std::int64_t row = static_cast<std::int64_t>(piece) / per_row;
                         const std::int64_t first = static_cast<std::int64_t>(piece) % per_row * chunk_length;
                         partial[piece] = chunk_sum(values + row * columns + first, std::min(chunk_length, columns - first));
                     }
                 });
    for (std::int64_t row = 0; row < rows; ++row)
    {
        double sum = 0;
        for (std::int64_t piece = 0; piece < per_row; ++piece)
            sum += partial[static_cast<std::size_t>(row * per_row + piece)];
        sums[row] = static_cast<T>(sum);
    }
}

/// The same of a tensor whose transpose is contiguous: pieces of columns, each summed row by row.
template <class T>
void row_sums_of_columns(const T* values, std::int64_t rows, std::int64_t columns, T* sums)
{
    const std::int64_t length = std::max<std::int64_t>(1, chunk_length / rows);
    const std::int64_t pieces = (columns + length - 1) / length;
    std::vector<double> partial(static_cast<std::size_t>(rows * pieces));
    parallel_for(static_cast<std::size_t>(pieces), 32, at::get_num_threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (auto piece = static_cast<std::int64_t>(begin); piece < static_cast<std::int64_t>(end); ++piece)
                     {
                         double* sum = partial.data() + piece * rows;
                         for (std::int64_t column = piece * length; column < std::min(columns, (piece + 1) * length); ++column)
                             for (std::int64_t row = 0; row < rows; ++row)
                                 sum[row] += static_cast<double>(values[column * rows + row]);
                     }
                 });
    for (std::int64_t row = 0; row < rows; ++row)
    {
        double sum = 0;
        for (std::int64_t piece = 0; piece < pieces; ++piece)
            sum += partial[static_cast<std::size_t>(piece * rows + row)];
        sums[row] = static_cast<T>(sum);
    }
}

bool has_contiguous_transpose(const at::Tensor& values)
{
    return values.dim() == 2 && values.size(0) > 1 && values.size(1) > 1 && values.t().is_contiguous();
}

/// R x N to R.
struct RowSums : torch::autograd::Function<RowSums>
{
    static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& values)
    {
        context->saved_data["columns"] = values.size(1);
        if (!values.device().is_cpu())
            return values.sum(1);
        const bool by_columns = has_contiguous_transpose(values);
        const auto source = by_columns ? values : values.contiguous();
        auto sums = at::empty({source.size(0)}, source.options());
        AT_DISPATCH_FLOATING_TYPES(source.scalar_type(), "ordered_sum",
                                   [&]
                                   {
                                       const auto add = by_columns ? row_sums_of_columns<scalar_t> : row_sums<scalar_t>;
                                       add(source.data_ptr<scalar_t>(), source.size(0), source.size(1),
                                           sums.data_ptr<scalar_t>());
                                   });
        return sums;
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const at::Tensor& gradient = gradients[0];
        return {gradient.unsqueeze(1).expand({gradient.size(0), context->saved_data["columns"].toInt()})};
    }
};

void check_type(const torch::Tensor& values)
{
    if (values.scalar_type() != at::kFloat && values.scalar_type() != at::kDouble)
        throw std::invalid_argument("ordered sums take float32 or float64 tensors");
}

}  // namespace

torch::Tensor ordered_sum(const torch::Tensor& values)
{
    check_type(values);
    const auto rows = has_contiguous_transpose(values) ? values.t() : values;
    return RowSums::apply(rows.reshape({1, values.numel()})).reshape({});
}

torch::Tensor ordered_sum(const torch::Tensor& values, std::int64_t dimension)
{
    check_type(values);
    const auto last = values.movedim(dimension, -1);
    const auto columns = last.size(-1);
    const auto shape = last.sizes().slice(0, static_cast<std::size_t>(last.dim() - 1));
    std::int64_t rows = 1;
    for (const auto size : shape)
        rows *= size;
    return RowSums::apply(last.reshape({rows, columns})).reshape(shape);
}

torch::Tensor ordered_mean(const torch::Tensor& values)
{
    return ordered_sum(values) / static_cast<double>(std::max<std::int64_t>(1, values.numel()));
}

torch::Tensor ordered_mean(const torch::Tensor& values, std::int64_t dimension)
{
    return ordered_sum(values, dimension) / static_cast<double>(std::max<std::int64_t>(1, values.size(dimension)));
}

}  // namespace fresco
