#pragma once

#include <fresco/image.h>
#include <fresco/value.h>

#include <torch/types.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace fresco
{

/// H x W x C picture to float32 C x H x W; 8-bit values are divided by 255.
torch::Tensor to_tensor(const Raster8& picture);
torch::Tensor to_tensor(const RasterF& picture);
/// C x H x W in [0,1] to H x W x C, clamped, rounded to 8 bits.
Raster8 to_raster8(const torch::Tensor& picture);

/// `tensor` on `device`. From the processor to another device it goes without waiting, on the current stream, and through
/// page-locked memory where the device is CUDA's; else as Tensor::to.
torch::Tensor sent_to(const torch::Tensor& tensor, const torch::Device& device);

/// a (M x K) times b (K x N), float32 or float64, of any strides, differentiable (once). Float32 on the CPU is multiplied by
/// multiply_matrices, because Debian's libtorch takes the reference BLAS (5 GFLOP/s against 200). The same bytes for any number
/// of torch threads. Throws std::invalid_argument for shapes or types that do not fit. Prefer it to at::mm, at::matmul and 1x1
/// convolutions: torch chooses the library for those by the number of threads.
torch::Tensor matrix_product(const torch::Tensor& a, const torch::Tensor& b);

/// Sum and mean over all elements (a scalar tensor), or over one dimension; float32 or float64, differentiable. On the CPU summed
/// in double precision in an order that the shape and the strides fix: the same bytes for any number of threads, which at::sum
/// and at::mean do not give. Use them for every reduction whose result is a loss. The mean of nothing is 0.
torch::Tensor ordered_sum(const torch::Tensor& values);
torch::Tensor ordered_sum(const torch::Tensor& values, std::int64_t dimension);
torch::Tensor ordered_mean(const torch::Tensor& values);
torch::Tensor ordered_mean(const torch::Tensor& values, std::int64_t dimension);

/// Named tensors in the safetensors format, with text metadata. Reading is strict and bounded: throws Error naming `file` and the
/// offset for a bad header, an unknown type, overlapping or gapped offsets, a shape that does not fit; MissingInput if it cannot
/// be opened.
struct SafeTensors
{
    std::map<std::string, torch::Tensor> tensors;
    std::map<std::string, std::string> metadata;
};
SafeTensors read_safetensors(const std::filesystem::path& file);
/// Writes whole or not at all; every type that weights::ElementType names. The same tensors give the same bytes.
void write_safetensors(const std::filesystem::path& file, const SafeTensors& contents);

}  // namespace fresco
