#include <fresco/torch/tensor.h>

#include <ATen/Context.h>
#include <ATen/ops/mkldnn_convolution.h>
#include <ATen/ops/mm.h>
#include <ATen/ops/zeros.h>
#include <torch/csrc/autograd/custom_function.h>

#include <stdexcept>

namespace fresco
{
namespace
{

bool convolves(const at::Tensor& a)
{
    return a.device().is_cpu() && a.scalar_type() == at::kFloat && at::hasMKLDNN();
}

/// The rows of `a` are the filters, the columns of `b` the pixels of a picture with K channels. Called by its own name and not as
/// at::conv2d, which takes the reference BLAS for 1x1 filters on one thread.
at::Tensor plain_product(const at::Tensor& a, const at::Tensor& b)
{
    const auto rows = a.size(0);
    const auto inner = a.size(1);
    const auto columns = b.size(1);
    if (rows == 0 || inner == 0 || columns == 0)
        return at::zeros({rows, columns}, a.options());
    if (!convolves(a))
        return at::mm(a, b);
    const auto filters = a.contiguous().view({rows, inner, 1, 1});
    const auto pixels = b.contiguous().view({1, inner, 1, columns});
    return at::mkldnn_convolution(pixels, filters, {}, {0, 0}, {1, 1}, {1, 1}, 1).contiguous().view({rows, columns});
}

/// Own backward, as two more products: oneDNN's gradient for filters splits its sums among the threads.
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
