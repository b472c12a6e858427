#include "far_device.h"

#include <ATen/ATen.h>
#include <ATen/EmptyTensor.h>
#include <ATen/core/dispatch/Dispatcher.h>
#include <ATen/core/stack.h>
#include <c10/core/impl/DeviceGuardImplInterface.h>
#include <torch/library.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <mutex>
#include <new>
#include <regex>
#include <stdexcept>
#include <vector>

namespace fresco::testing
{
namespace
{

constexpr auto far_type = c10::DeviceType::PrivateUse1;

std::mutex traffic_mutex;
FarTraffic traffic;
std::intptr_t moment = 0;  ///< Rises with every operator and event.

/// A copy to the processor that it does not wait for: it is there when an event that was recorded later has come.
struct LateCopy
{
    std::intptr_t sent;
    at::Tensor from;
    at::Tensor to;
};
std::vector<LateCopy> late_copies;

void count_wait(const std::string& name)
{
    const std::lock_guard lock(traffic_mutex);
    ++traffic.waits[name];
}

void count_launch(const std::string& name)
{
    const std::lock_guard lock(traffic_mutex);
    ++traffic.launches[name];
    ++moment;
}

/// Memory mapped twice: the addresses of the device's tensors cannot be read or written.
struct Block
{
    explicit Block(std::size_t wanted) : bytes(std::max<std::size_t>(wanted, 1))
    {
        const int file = memfd_create("far", MFD_CLOEXEC);
        if (file < 0 || ftruncate(file, static_cast<off_t>(bytes)) != 0)
            throw std::bad_alloc();
        far = mmap(nullptr, bytes, PROT_NONE, MAP_SHARED, file, 0);
        near = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        close(file);
        if (far == MAP_FAILED || near == MAP_FAILED)
            throw std::bad_alloc();
    }
    ~Block()
    {
        munmap(far, bytes);
        munmap(near, bytes);
    }
    Block(const Block&) = delete;
    Block& operator=(const Block&) = delete;

    std::size_t bytes;
    void* far = nullptr;
    void* near = nullptr;
};

void keep_block(void*) {}

c10::Storage far_storage(std::size_t bytes)
{
    auto* block = new Block(bytes);
    return {c10::Storage::use_byte_size_t(), bytes,
            at::DataPtr(
                block->far, block, [](void* own) { delete static_cast<Block*>(own); }, c10::Device(far_type, 0)),
            nullptr, false};
}

at::Tensor with_storage(c10::Storage storage, c10::DispatchKey key, caffe2::TypeMeta type)
{
    return at::detail::make_tensor<c10::TensorImpl>(std::move(storage), c10::DispatchKeySet(key), type);
}

at::Tensor empty_strided(at::IntArrayRef sizes, at::IntArrayRef strides, c10::optional<at::ScalarType> type,
                         c10::optional<at::Layout> = {}, c10::optional<at::Device> = {}, c10::optional<bool> = {})
{
    const auto meta = c10::scalarTypeToTypeMeta(type.value_or(at::kFloat));
    auto tensor = with_storage(far_storage(at::detail::computeStorageNbytes(sizes, strides, meta.itemsize())),
                               c10::DispatchKey::PrivateUse1, meta);
    tensor.unsafeGetTensorImpl()->set_sizes_and_strides(sizes, strides);
    return tensor;
}

bool is_far(const at::Tensor& tensor)
{
    return tensor.defined() && tensor.device().type() == far_type;
}

/// A tensor of these bytes that is laid out as another one.
at::Tensor laid_out_as(const at::Tensor& tensor, c10::Storage storage, c10::DispatchKey key)
{
    auto view = with_storage(std::move(storage), key, tensor.dtype());
    view.unsafeGetTensorImpl()->set_storage_offset(tensor.storage_offset());
    view.unsafeGetTensorImpl()->set_sizes_and_strides(tensor.sizes(), tensor.strides());
    return view;
}

/// The far tensor as a CPU tensor of the same memory.
at::Tensor near_view(const at::Tensor& tensor)
{
    auto* block = static_cast<Block*>(tensor.storage().data_ptr().get_context());
    c10::Storage storage(c10::Storage::use_byte_size_t(), tensor.storage().nbytes(),
                         at::DataPtr(block->near, block, &keep_block, c10::Device(at::kCPU)), c10::GetAllocator(at::kCPU), true);
    return laid_out_as(tensor, std::move(storage), c10::DispatchKey::CPU);
}

at::Tensor to_far(const at::Tensor& near)
{
    auto tensor = empty_strided(near.sizes(), near.strides(), near.scalar_type());
    near_view(tensor).copy_(near);
    return tensor;
}

/// One call of an operator by its CPU kernel.
class Call
{
  public:
    /// `op` by the kernel of an operator that takes the same arguments and gives the same.
    Call(const c10::OperatorHandle& op, const c10::OperatorHandle& kernel) : op_(op), kernel_(kernel) {}

    void operator()(torch::jit::Stack* stack)
    {
        const auto count = kernel_.schema().arguments().size();
        for (std::size_t i = stack->size() - count; i < stack->size(); ++i)
            (*stack)[i] = taken_near((*stack)[i]);
        if (far_seen_ && mixed_)
            throw std::runtime_error("far device: " + op_.schema().name() + " is given tensors of both sides");
        note_wait();
        note_launch();
        kernel_.callBoxed(stack);
        for (std::size_t i = stack->size() - op_.schema().returns().size(); i < stack->size(); ++i)
            (*stack)[i] = taken_far((*stack)[i]);
        for (const auto& [far, near] : pairs_)
            follow(near, far.unsafeGetTensorImpl());
    }

  private:
    at::Tensor near_of(const at::Tensor& tensor)
    {
        if (!is_far(tensor))
        {
            // As with CUDA, a number may come from the processor.
            mixed_ = mixed_ || (tensor.defined() && tensor.dim() > 0);
            return tensor;
        }
        far_seen_ = true;
        return pairs_.emplace_back(tensor, near_view(tensor)).second;
    }

    c10::IValue taken_near(const c10::IValue& value)
    {
        if (value.isTensor())
            return near_of(value.toTensor());
        if (value.isTensorList())
        {
            c10::List<at::Tensor> list;
            for (const at::Tensor& tensor : value.toTensorVector())
                list.push_back(near_of(tensor));
            return list;
        }
        if (value.isOptionalTensorList())
        {
            c10::List<c10::optional<at::Tensor>> list;
            for (const auto& tensor : value.toOptionalTensorVector())
            {
                by_mask_ = by_mask_ || (tensor && tensor->scalar_type() == at::kBool);
                list.push_back(tensor ? c10::make_optional(near_of(*tensor)) : c10::nullopt);
            }
            return list;
        }
        if (value.isDevice() && value.toDevice().type() == far_type)
        {
            far_seen_ = true;
            return c10::Device(at::kCPU);
        }
        return value;
    }

    at::Tensor far_of(const at::Tensor& result) const
    {
        if (!result.defined() || !far_seen_ || is_far(result))
            return result;
        for (const auto& [far, near] : pairs_)
            if (result.is_same(near))
                return far;
        const auto& data = result.storage().data_ptr();
        if (data.get_deleter() != &keep_block)
            return to_far(result);
        for (const auto& [far, near] : pairs_)
            if (far.storage().data_ptr().get_context() == data.get_context())
                return laid_out_as(result, far.storage(), c10::DispatchKey::PrivateUse1);
        throw std::logic_error("far device: a result lies in the memory of no argument");
    }

    c10::IValue taken_far(const c10::IValue& value) const
    {
        if (value.isTensor())
            return far_of(value.toTensor());
        if (!value.isTensorList())
            return value;
        c10::List<at::Tensor> list;
        for (const at::Tensor& tensor : value.toTensorVector())
            list.push_back(far_of(tensor));
        return list;
    }

    /// An argument that was resized or moved is so on the device too.
    static void follow(const at::Tensor& near, c10::TensorImpl* far)
    {
        const bool moved = near.storage().data_ptr().get_deleter() != &keep_block;
        if (moved)
            far->set_storage_keep_dtype(to_far(near).storage());
        if (const auto offset = moved ? 0 : near.storage_offset(); offset != far->storage_offset())
            far->set_storage_offset(offset);
        if (near.sizes() != far->sizes() || near.strides() != far->strides())
            far->set_sizes_and_strides(near.sizes(), near.strides());
    }

    void note_wait() const
    {
        static const std::regex sized_by_values(
            "aten::(nonzero|masked_select|_unique2?|unique_consecutive|unique_dim|unique_dim_consecutive|equal|is_nonzero|"
            "bincount|_local_scalar_dense|is_set_to|histc)");
        const auto& name = op_.schema().name();
        if (far_seen_ && (by_mask_ || std::regex_match(name, sized_by_values)))
            count_wait(name);
    }

    /// Views and new tensors need no kernel.
    void note_launch() const
    {
        const auto& name = op_.schema().name();
        const auto& returns = op_.schema().returns();
        const bool is_view = !returns.empty() && returns[0].alias_info() != nullptr && !returns[0].alias_info()->isWrite();
        if (!far_seen_ || is_view || name == "aten::_reshape_alias" || name == "aten::resize_" || name.starts_with("aten::empty"))
            return;
        count_launch(name);
    }

    const c10::OperatorHandle& op_;
    const c10::OperatorHandle& kernel_;
    std::vector<std::pair<at::Tensor, at::Tensor>> pairs_;  ///< Far arguments, and their memory on the processor.
    bool far_seen_ = false;
    bool mixed_ = false;
    bool by_mask_ = false;
};

void on_the_processor(const c10::OperatorHandle& op, torch::jit::Stack* stack)
{
    Call(op, op)(stack);
}

c10::OperatorHandle operator_named(const char* name)
{
    return c10::Dispatcher::singleton().findSchemaOrThrow(name, "");
}

/// Other devices than those that libtorch knows have operators of their own for convolutions.
void convolution(const c10::OperatorHandle& op, torch::jit::Stack* stack)
{
    Call(op, operator_named("aten::convolution"))(stack);
}

void convolution_backward(const c10::OperatorHandle& op, torch::jit::Stack* stack)
{
    // The sizes of the bias, which follow the three tensors: none.
    stack->insert(stack->end() - static_cast<std::ptrdiff_t>(op.schema().arguments().size()) + 3, c10::IValue());
    Call(op, operator_named("aten::convolution_backward"))(stack);
}

at::Tensor empty(at::IntArrayRef sizes, c10::optional<at::ScalarType> type, c10::optional<at::Layout>, c10::optional<at::Device>,
                 c10::optional<bool>, c10::optional<at::MemoryFormat> format)
{
    const auto meta = at::empty(sizes, at::TensorOptions(at::kMeta).dtype(type.value_or(at::kFloat)), format);
    return empty_strided(meta.sizes(), meta.strides(), type);
}

at::Tensor copy_from(const at::Tensor& from, const at::Tensor& to, bool non_blocking)
{
    if (is_far(from) || is_far(to))
        count_launch("copy");
    if (!is_far(to) && non_blocking && at::isFloatingType(to.scalar_type()))
    {
        to.fill_(std::numeric_limits<double>::quiet_NaN());
        const std::lock_guard lock(traffic_mutex);
        late_copies.push_back({moment, near_view(from).clone(), to});
        return to;
    }
    if (!is_far(to))
        count_wait("copy to the processor");
    else if (!is_far(from))
    {
        const std::lock_guard lock(traffic_mutex);
        ++(non_blocking ? traffic.to_device_later : traffic.to_device);
    }
    (is_far(to) ? near_view(to) : to).copy_(is_far(from) ? near_view(from) : from);
    return to;
}

/// Streams are distinct, but all work is done immediately.
class Guard final : public c10::impl::DeviceGuardImplInterface
{
  public:
    c10::DeviceType type() const override { return far_type; }
    c10::Device exchangeDevice(c10::Device) const override { return getDevice(); }
    c10::Device getDevice() const override { return {far_type, 0}; }
    void setDevice(c10::Device) const override {}
    void uncheckedSetDevice(c10::Device) const noexcept override {}
    c10::Stream getStream(c10::Device) const noexcept override { return stream(current()); }
    c10::Stream getDefaultStream(c10::Device) const override { return stream(0); }
    c10::Stream getStreamFromGlobalPool(c10::Device, bool) const override { return stream(1); }
    c10::Stream exchangeStream(c10::Stream next) const noexcept override
    {
        const auto before = current();
        current() = next.id();
        return stream(before);
    }
    c10::DeviceIndex deviceCount() const noexcept override { return 1; }
    void record(void** event, const c10::Stream&, const c10::DeviceIndex, const c10::EventFlag) const override
    {
        const std::lock_guard lock(traffic_mutex);
        *event = reinterpret_cast<void*>(++moment);
        ++traffic.events_recorded;
    }
    /// Waits until it has come.
    bool queryEvent(void* event) const override
    {
        std::vector<LateCopy> arrived;
        {
            const std::lock_guard lock(traffic_mutex);
            ++traffic.events_awaited;
            // Without anything that was sent since, the device would run out of work.
            if (reinterpret_cast<std::intptr_t>(event) == moment)
                ++traffic.waits["event"];
            const auto later = std::ranges::partition(late_copies, [&](const LateCopy& copy)
                                                      { return copy.sent > reinterpret_cast<std::intptr_t>(event); });
            arrived.assign(later.begin(), later.end());
            late_copies.erase(later.begin(), later.end());
        }
        for (const auto& copy : arrived)
            copy.to.copy_(copy.from);
        return true;
    }
    void block(void* event, const c10::Stream&) const override
    {
        if (event == nullptr)
            return;
        const std::lock_guard lock(traffic_mutex);
        ++traffic.events_awaited;
    }
    void synchronizeStream(const c10::Stream&) const override { count_wait("synchronizeStream"); }

  private:
    static c10::StreamId& current()
    {
        thread_local c10::StreamId id = 0;
        return id;
    }
    static c10::Stream stream(c10::StreamId id) { return c10::Stream(c10::Stream::UNSAFE, c10::Device(far_type, 0), id); }
};

}  // namespace

std::int64_t FarTraffic::wait_count() const
{
    std::int64_t count = to_device;
    for (const auto& [name, times] : waits)
        count += times;
    return count;
}

namespace
{

C10_REGISTER_GUARD_IMPL(PrivateUse1, Guard);

TORCH_LIBRARY_IMPL(aten, PrivateUse1, library)
{
    library.impl("empty.memory_format", TORCH_FN(empty));
    library.impl("empty_strided", TORCH_FN(empty_strided));
    library.impl("_copy_from", TORCH_FN(copy_from));
    library.impl("convolution_overrideable", torch::CppFunction::makeFromBoxedFunction<&convolution>());
    library.impl("convolution_backward_overrideable", torch::CppFunction::makeFromBoxedFunction<&convolution_backward>());
}

/// As with CUDA, operators on lists of tensors are one each.
TORCH_LIBRARY_IMPL(aten, PrivateUse1, library)
{
    for (const auto& op : c10::Dispatcher::singleton().getAllOpNames())
        if (op.name.starts_with("aten::_foreach_"))
            library.impl((op.name.substr(6) + (op.overload_name.empty() ? "" : "." + op.overload_name)).c_str(),
                         torch::CppFunction::makeFromBoxedFunction<&on_the_processor>());
}

TORCH_LIBRARY_IMPL(_, PrivateUse1, library)
{
    library.fallback(torch::CppFunction::makeFromBoxedFunction<&on_the_processor>());
}

}  // namespace

torch::Device far_device()
{
    return {far_type, 0};
}

FarTraffic far_traffic()
{
    const std::lock_guard lock(traffic_mutex);
    return traffic;
}

void forget_far_traffic()
{
    const std::lock_guard lock(traffic_mutex);
    traffic = {};
}

}  // namespace fresco::testing
