#include <fresco/matrix_multiply.h>
#include <fresco/torch/tensor.h>

#include <ATen/Parallel.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/mm.h>
#include <torch/csrc/autograd/custom_function.h>

#include <stdexcept>

namespace fresco
{
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

}  // namespace fresco
