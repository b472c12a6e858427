#include "pickle_machine.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>

/// \file What the globals of state dicts stand for. The list below is all there is.

namespace fresco::weights::detail
{
namespace
{

constexpr std::size_t most_dimensions = 8;
constexpr std::size_t most_arguments = 16;
constexpr std::size_t most_storages = 4096;

struct KnownGlobal
{
    std::string_view module;
    std::string_view name;
    Global global;
    ElementType type = ElementType::float32;
};
constexpr std::array<KnownGlobal, 15> known_globals{{
    {"collections", "OrderedDict", Global::ordered_dict},
    {"torch._utils", "_rebuild_tensor", Global::rebuild_tensor},
    {"torch._utils", "_rebuild_tensor_v2", Global::rebuild_tensor},
    {"torch._utils", "_rebuild_parameter", Global::rebuild_parameter},
    {"torch.nn.parameter", "Parameter", Global::parameter},
    {"torch", "DoubleStorage", Global::storage_type, ElementType::float64},
    {"torch", "FloatStorage", Global::storage_type, ElementType::float32},
    {"torch", "HalfStorage", Global::storage_type, ElementType::float16},
    {"torch", "BFloat16Storage", Global::storage_type, ElementType::bfloat16},
    {"torch", "LongStorage", Global::storage_type, ElementType::int64},
    {"torch", "IntStorage", Global::storage_type, ElementType::int32},
    {"torch", "ShortStorage", Global::storage_type, ElementType::int16},
    {"torch", "ByteStorage", Global::storage_type, ElementType::uint8},
    {"torch", "CharStorage", Global::storage_type, ElementType::int8},
    {"torch", "BoolStorage", Global::storage_type, ElementType::boolean},
}};

/// Only what can be printed.
std::string printable(std::string_view text)
{
    std::string result;
    for (const char c : text.substr(0, 80))
        result += c >= 0x20 && c < 0x7f ? c : '?';
    return result;
}

bool is_row_major(const std::vector<std::int64_t>& shape, const std::vector<std::int64_t>& strides)
{
    std::int64_t expected = 1;
    for (std::size_t i = shape.size(); i-- > 0;)
    {
        if (shape[i] != 1 && strides[i] != expected)
            return false;
        expected *= shape[i];
    }
    return true;
}

}  // namespace

void PickleMachine::push_global(std::string_view module, std::string_view name)
{
    for (const auto& known : known_globals)
        if (known.module == module && known.name == name)
        {
            push(Node{.kind = Kind::global, .global = known.global, .type = known.type});
            return;
        }
    fail(operation_,
         "names '" + printable(module) + "." + printable(name) + "', which no state dict needs (nothing was executed)");
}

Node PickleMachine::pop_arguments()
{
    const Node& tuple = nodes_[pop()];
    if (tuple.kind != Kind::tuple || tuple.items.size() > most_arguments)
        fail(operation_, "a call without a tuple of arguments");
    return tuple;
}

/// ('storage', type, key, location, number of elements[, view]).
void PickleMachine::push_storage()
{
    const Node tuple = pop_arguments();
    const auto kind = [&](std::size_t i) { return nodes_[tuple.items[i]].kind; };
    if (tuple.items.size() < 5 || tuple.items.size() > 6 || kind(0) != Kind::text || nodes_[tuple.items[0]].text != "storage" ||
        kind(1) != Kind::global || kind(2) != Kind::text || kind(3) != Kind::text || kind(4) != Kind::integer)
        fail(operation_, "a reference to something other than a storage");
    const Node& type = nodes_[tuple.items[1]];
    const std::int64_t count = nodes_[tuple.items[4]].integer;
    if (type.global != Global::storage_type || count < 0)
        fail(operation_, "a storage without a type or with a negative size");
    if (tuple.items.size() == 6 && kind(5) != Kind::none)
        fail(operation_, "a storage that is a view of another");
    const Storage storage{nodes_[tuple.items[2]].text, type.type, static_cast<std::uint64_t>(count)};
    auto found = std::ranges::find(storages_, storage.key, &Storage::key);
    if (found == storages_.end() && storages_.size() >= most_storages)
        fail(operation_, fmt::format("more than {} storages", most_storages));
    if (found == storages_.end())
        found = storages_.insert(storages_.end(), storage);
    else if (found->type != storage.type || found->count != storage.count)
        fail(operation_, "the storage '" + printable(storage.key) + "' with two types or sizes");
    push(Node{.kind = Kind::storage, .integer = found - storages_.begin()});
}

void PickleMachine::reduce()
{
    const Node arguments = pop_arguments();
    const Node& callable = nodes_[pop()];
    if (callable.kind != Kind::global)
        fail(operation_, "a call of what cannot be called");
    switch (callable.global)
    {
    case Global::ordered_dict:
        ordered_dict(arguments);
        return;
    case Global::rebuild_tensor:
        rebuild_tensor(arguments);
        return;
    case Global::rebuild_parameter:
        if (arguments.items.empty() || nodes_[arguments.items[0]].kind != Kind::tensor)
            fail(operation_, "a parameter without a tensor");
        push(arguments.items[0]);
        return;
    default:
        fail(operation_, "a call of what cannot be called");
    }
}

/// Empty, or Python 2's list of pairs.
void PickleMachine::ordered_dict(const Node& arguments)
{
    Node result{.kind = Kind::dictionary};
    if (arguments.items.size() > 1 || (arguments.items.size() == 1 && nodes_[arguments.items[0]].kind != Kind::list))
        fail(operation_, "an OrderedDict that is not made of pairs");
    if (!arguments.items.empty())
        for (const Handle pair : nodes_[arguments.items[0]].items)
        {
            if ((nodes_[pair].kind != Kind::list && nodes_[pair].kind != Kind::tuple) || nodes_[pair].items.size() != 2)
                fail(operation_, "an OrderedDict that is not made of pairs");
            extend(result, nodes_[pair].items);
        }
    push(std::move(result));
}

std::vector<std::int64_t> PickleMachine::numbers(Handle tuple)
{
    const Node& node = nodes_[tuple];
    std::vector<std::int64_t> result;
    if (node.kind != Kind::tuple || node.items.size() > most_dimensions)
        fail(operation_, "a tensor whose shape is not a tuple of at most 8 numbers");
    for (const Handle item : node.items)
    {
        const Node& number = nodes_[item];
        if (number.kind != Kind::integer || number.integer < 0)
            fail(operation_, "a tensor whose shape is not a tuple of at most 8 numbers");
        result.push_back(number.integer);
    }
    return result;
}

/// (storage, offset, size, stride, …)
void PickleMachine::rebuild_tensor(const Node& arguments)
{
    if (arguments.items.size() < 4 || nodes_[arguments.items[0]].kind != Kind::storage ||
        nodes_[arguments.items[1]].kind != Kind::integer || nodes_[arguments.items[1]].integer < 0)
        fail(operation_, "a tensor without a storage and an offset in it");
    StoredTensor tensor;
    tensor.storage = static_cast<std::size_t>(nodes_[arguments.items[0]].integer);
    tensor.offset = static_cast<std::uint64_t>(nodes_[arguments.items[1]].integer);
    const auto shape = numbers(arguments.items[2]);
    const auto strides = numbers(arguments.items[3]);
    if (shape.size() != strides.size())
        fail(operation_, "a tensor with a stride for not each dimension");
    const std::uint64_t available = storages_[tensor.storage].count;
    tensor.count = 1;
    for (const std::int64_t extent : shape)
    {
        const auto size = static_cast<std::uint64_t>(extent);
        if (size != 0 && tensor.count > available / size)
            fail(operation_, "a tensor that is larger than its storage");
        tensor.count *= size;
        tensor.shape.push_back(size);
    }
    if (tensor.offset > available || tensor.count > available - tensor.offset)
        fail(operation_, "a tensor that is larger than its storage");
    if (tensor.count > 0 && !is_row_major(shape, strides))
        fail(operation_, "a tensor whose elements do not lie in row-major order; save it after .contiguous()");
    tensors_.push_back(std::move(tensor));
    push(Node{.kind = Kind::tensor, .integer = static_cast<std::int64_t>(tensors_.size() - 1)});
}

/// Parameters as PyTorch before 0.2 wrote them: Parameter() or Parameter(tensor, …).
void PickleMachine::new_object()
{
    const Node arguments = pop_arguments();
    const Node& callable = nodes_[pop()];
    if (callable.kind != Kind::global || callable.global != Global::parameter)
        fail(operation_, "makes an object that no state dict needs");
    if (arguments.items.empty())
        push(Node{.kind = Kind::parameter});
    else if (nodes_[arguments.items[0]].kind == Kind::tensor)
        push(arguments.items[0]);
    else
        fail(operation_, "a parameter without a tensor");
}

void PickleMachine::build()
{
    const Node& state = nodes_[pop()];
    Node& object = top();
    if (object.kind == Kind::parameter && state.kind == Kind::tuple && !state.items.empty() &&
        nodes_[state.items[0]].kind == Kind::tensor)
    {
        object.kind = Kind::tensor;
        object.integer = nodes_[state.items[0]].integer;
    }
    // The attributes of an OrderedDict: `_metadata`, the versions of the modules.
    else if ((object.kind != Kind::dictionary && object.kind != Kind::tensor) || state.kind == Kind::storage)
        fail(operation_, "sets attributes of what has none");
}

}  // namespace fresco::weights::detail
