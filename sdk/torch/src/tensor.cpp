#include <fresco/files_io.h>
#include <fresco/math.h>
#include <fresco/parallel.h>
#include <fresco/torch/tensor.h>
#include <fresco/torch/tensor_memory.h>
#include <fresco/weights/state_dict.h>

#include <ATen/Dispatch.h>
#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/mm.h>
#include <c10/util/accumulate.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace fresco
{
namespace
{

/// H x W x C values to C x H x W, each through `convert`.
template <class From, class Convert>
torch::Tensor planes(const Raster<From>& picture, Convert convert)
{
    const std::int64_t channels = picture.channels;
    const std::int64_t pixels = std::int64_t{picture.width} * picture.height;
    at::Tensor tensor = at::empty({channels, picture.height, picture.width}, at::kFloat);
    float* out = tensor.data_ptr<float>();
    for (std::int64_t c = 0; c < channels; ++c)
        for (std::int64_t i = 0; i < pixels; ++i)
            out[c * pixels + i] = convert(picture.values[static_cast<std::size_t>(i * channels + c)]);
    return tensor;
}

}  // namespace

torch::Tensor sent_to(const torch::Tensor& tensor, const torch::Device& device)
{
    if (device.is_cpu() || !tensor.device().is_cpu())
        return tensor.to(device);
    if (tensor.numel() == 0)
        return at::empty(tensor.sizes(), tensor.options().device(device));
    // From other memory CUDA copies while the processor waits, and it waits for everything sent before.
    const auto source = device.is_cuda() ? tensor.contiguous().pin_memory() : tensor;
    return source.to(source.options().device(device), true);
}

torch::Tensor to_tensor(const Raster8& picture)
{
    return planes(picture, [](std::uint8_t v) { return static_cast<float>(v) / 255.0F; });
}

torch::Tensor to_tensor(const RasterF& picture)
{
    return planes(picture, [](float v) { return v; });
}

Raster8 to_raster8(const torch::Tensor& picture)
{
    if (picture.dim() != 3)
        throw std::invalid_argument("a picture tensor has the shape C x H x W");
    const auto source = picture.detach().to(at::kCPU, at::kFloat).contiguous();
    const std::int64_t channels = source.size(0);
    const std::int64_t pixels = source.size(1) * source.size(2);
    Raster8 raster(static_cast<int>(source.size(2)), static_cast<int>(source.size(1)), static_cast<int>(channels));
    const float* in = source.data_ptr<float>();
    for (std::int64_t c = 0; c < channels; ++c)
        for (std::int64_t i = 0; i < pixels; ++i)
        {
            // std::clamp would pass NaN on, and converting NaN is undefined.
            const float v = in[c * pixels + i];
            const float level = v >= 0 ? std::min(v, 1.0F) * 255.0F : 0.0F;
            raster.values[static_cast<std::size_t>(i * channels + c)] = static_cast<std::uint8_t>(std::lround(level));
        }
    return raster;
}

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

/// The sum of a row's parts, from the first to the last, `step` apart.
template <class T>
T sum_of_parts(const double* parts, std::int64_t count, std::int64_t step)
{
    double sum = 0;
    for (std::int64_t i = 0; i < count; ++i)
        sum += parts[i * step];
    return static_cast<T>(sum);
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
        sums[row] = sum_of_parts<T>(partial.data() + row * per_row, per_row, 1);
}

/// Row sums of a tensor whose transpose is contiguous: blocks of columns, each summed row by row.
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
        sums[row] = sum_of_parts<T>(partial.data() + row, pieces, rows);
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
    return RowSums::apply(last.reshape({c10::multiply_integers(shape), columns})).reshape(shape);
}

torch::Tensor ordered_mean(const torch::Tensor& values)
{
    return ordered_sum(values) / static_cast<double>(std::max<std::int64_t>(1, values.numel()));
}

torch::Tensor ordered_mean(const torch::Tensor& values, std::int64_t dimension)
{
    return ordered_sum(values, dimension) / static_cast<double>(std::max<std::int64_t>(1, values.size(dimension)));
}

namespace
{

MatrixView view(const at::Tensor& matrix)
{
    return {matrix.data_ptr<float>(), static_cast<std::size_t>(matrix.size(0)), static_cast<std::size_t>(matrix.size(1)),
            matrix.stride(0), matrix.stride(1)};
}

at::Tensor plain_product(const at::Tensor& a, const at::Tensor& b)
{
    if (!a.device().is_cpu() || a.scalar_type() != at::kFloat)
        return at::mm(a, b);
    auto product = at::empty({a.size(0), b.size(1)}, a.options());
    multiply_matrices(view(a), view(b), product.data_ptr<float>(), at::get_num_threads());
    return product;
}

/// Its backward is two more products.
struct MatrixProduct : torch::autograd::Function<MatrixProduct>
{
    static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& a, const at::Tensor& b)
    {
        context->save_for_backward({a, b});
        return plain_product(a, b);
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto saved = context->get_saved_variables();
        const at::Tensor& gradient = gradients[0];
        at::Tensor for_a;
        at::Tensor for_b;
        if (context->needs_input_grad(0))
            for_a = plain_product(gradient, saved[1].t());
        if (context->needs_input_grad(1))
            for_b = plain_product(saved[0].t(), gradient);
        return {for_a, for_b};
    }
};

}  // namespace

torch::Tensor matrix_product(const torch::Tensor& a, const torch::Tensor& b)
{
    if (a.dim() != 2 || b.dim() != 2 || a.size(1) != b.size(0))
        throw std::invalid_argument("matrix_product takes an M x K and a K x N matrix");
    if (a.scalar_type() != b.scalar_type() || (a.scalar_type() != at::kFloat && a.scalar_type() != at::kDouble))
        throw std::invalid_argument("matrix_product takes two float32 or two float64 matrices");
    return MatrixProduct::apply(a, b);
}

namespace
{

using weights::ElementType;

/// In the order of ElementType.
constexpr std::array types{at::kDouble,   at::kLong,  at::kFloat, at::kInt,  at::kHalf,
                           at::kBFloat16, at::kShort, at::kByte,  at::kChar, at::kBool};

torch::Tensor to_tensor(const weights::TensorView& view)
{
    const at::ScalarType type = types.at(static_cast<std::size_t>(view.type));
    constexpr std::size_t large = std::size_t{1} << 20U;
    const std::vector<std::int64_t> shape(view.shape.begin(), view.shape.end());
    if (view.bytes.size() >= large)
    {
        // Much of a large texture's checkpoint is zero.
        auto result = lazy_zeros(shape, type);
        write_bytes(view.bytes, result);
        return result;
    }
    auto result = at::empty(shape, type);
    if (!view.bytes.empty())
        std::memcpy(result.data_ptr(), view.bytes.data(), view.bytes.size());
    return result;
}

ElementType written_type(const std::string& name, const torch::Tensor& tensor)
{
    const auto type = std::ranges::find(types, tensor.scalar_type());
    if (type == types.end())
        throw std::invalid_argument("write_safetensors: tensor '" + name + "' has a type that is not written");
    return static_cast<ElementType>(type - types.begin());
}

}  // namespace

SafeTensors read_safetensors(const std::filesystem::path& file)
{
    const auto bytes = read_file(file);
    auto contents = weights::parse_safetensors(bytes, file.string());
    SafeTensors result;
    for (const auto& view : contents.tensors)
        result.tensors.emplace(view.name, to_tensor(view));
    result.metadata = std::move(contents.metadata);
    return result;
}

void write_safetensors(const std::filesystem::path& file, const SafeTensors& contents)
{
    std::vector<torch::Tensor> kept;
    std::vector<weights::TensorView> views;
    for (const auto& [name, tensor] : contents.tensors)
    {
        const ElementType type = written_type(name, tensor);
        kept.push_back(tensor.detach().to(at::kCPU).contiguous());
        views.push_back({name,
                         type,
                         {kept.back().sizes().begin(), kept.back().sizes().end()},
                         {static_cast<const std::byte*>(kept.back().data_ptr()), kept.back().nbytes()}});
    }
    weights::write_safetensors(file, views, contents.metadata);
}

}  // namespace fresco
