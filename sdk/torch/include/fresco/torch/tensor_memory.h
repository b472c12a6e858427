#pragma once

/// \file Memory of large tensors on the CPU. Of a texture, and of what an optimizer remembers of it, often only a part differs
/// from zero: pages that nobody has written take no memory (lazy_zeros). Pages of freed tensors serve later ones
/// (reuse_tensor_memory).

#include <torch/types.h>

#include <cstddef>
#include <span>

namespace fresco
{

/// Zeros of `shape`, contiguous, in pages of their own: one takes memory when something is first written into it, reading gives
/// zeros and takes none. No huge pages. Fill such a tensor by write_values and write_zeros: at::copy_ and at::zero_ write every
/// page. Throws std::bad_alloc where the address space is used up.
torch::Tensor lazy_zeros(at::IntArrayRef shape, at::ScalarType type);

/// Makes `to` (contiguous) equal to `from` (same shape and type, contiguous, on the CPU), to the last bit. Pages that are equal
/// already are only read. Throws std::invalid_argument for tensors that do not fit. A `to` on another device than the CPU is
/// written by libtorch, as by the functions below.
void write_values(const torch::Tensor& from, torch::Tensor& to);
/// Writes `to` from as many bytes as it has.
void write_bytes(std::span<const std::byte> from, torch::Tensor& to);

/// Makes `to` (contiguous) all zero bits; pages that are so already are only read.
void write_zeros(torch::Tensor& to);

/// Brings the values of `to` (float32, contiguous) that lie outside into [least, most]; writes these alone.
void write_clamped(torch::Tensor& to, float least, float most);

/// From now on large tensors on the CPU get their memory from pages that earlier tensors have left, whatever their sizes were:
/// what the process holds is what its tensors held at most at one time, plus at most 2 MB for each. Otherwise it is the
/// allocator's choice between holes that no later tensor fits in and giving pages back, which then have to be cleared again.
/// For the whole process; once is enough. Any thread.
void reuse_tensor_memory();

/// Bytes that the pages take which reuse_tensor_memory() manages, in use or waiting.
std::size_t reused_tensor_bytes();

}  // namespace fresco
