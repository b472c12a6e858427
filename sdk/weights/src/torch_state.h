#pragma once

#include "pickle_machine.h"

#include <functional>

namespace fresco::weights::detail
{

/// The tensors of a state dict whose storages have been found: `bytes_of(i)` are all bytes of storage i. Throws Error through the
/// machine for an entry that is no tensor, a name that is there twice or no name.
std::vector<TensorView> tensors_of(const PickleMachine& machine, const Node& root,
                                   const std::function<std::span<const std::byte>(std::size_t storage)>& bytes_of);

}  // namespace fresco::weights::detail
