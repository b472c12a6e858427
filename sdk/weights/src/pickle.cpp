/// \file What the globals of state dicts stand for. The list below is all there is.

#include "pickle.h"

#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <utility>

namespace fresco::weights::detail
{
namespace
{

// A state dict of VGG-19 takes about 5 KB. An operation makes one value at the most; only calls multiply the items.
constexpr std::size_t longest_pickle = std::size_t{1} << 20U;
constexpr std::size_t most_items = 1'000'000;
constexpr std::size_t longest_text = 4096;

}  // namespace

void PickleMachine::fail(std::size_t offset, const std::string& what) const
{
    throw Error(fmt::format("{}: byte {}: {}; not a state dict as torch.save(model.state_dict(), file) writes it", source_,
                            offset, what));
}

std::span<const std::byte> PickleMachine::take(std::uint64_t count)
{
    if (count > bytes_.size() - position_)
        fail(operation_, "the pickle ends in the middle");
    const auto taken = bytes_.subspan(position_, static_cast<std::size_t>(count));
    position_ += taken.size();
    if (position_ - start_ > longest_pickle)
        fail(operation_, "a pickle of more than 1 MiB");
    return taken;
}

std::uint64_t PickleMachine::unsigned_number(std::size_t bytes)
{
    std::uint64_t number = 0;
    std::memcpy(&number, take(bytes).data(), bytes);
    return number;
}

std::string_view PickleMachine::text(std::uint64_t count)
{
    if (count > longest_text)
        fail(operation_, fmt::format("a text of {} bytes", count));
    const auto taken = take(count);
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
}

std::string_view PickleMachine::line()
{
    for (std::size_t count = 0; count < longest_text && position_ + count < bytes_.size(); ++count)
        if (bytes_[position_ + count] == std::byte{'\n'})
        {
            const auto result = text(count);
            take(1);
            return result;
        }
    fail(operation_, "a line without an end");
}

void PickleMachine::push(Node node)
{
    nodes_.push_back(std::move(node));
    stack_.push_back(static_cast<Handle>(nodes_.size() - 1));
}

Handle PickleMachine::pop()
{
    if (stack_.size() <= (marks_.empty() ? 0 : marks_.back()))
        fail(operation_, "a value is missing on the stack");
    const Handle handle = stack_.back();
    stack_.pop_back();
    return handle;
}

std::vector<Handle> PickleMachine::pop_to_mark()
{
    if (marks_.empty())
        fail(operation_, "a mark is missing on the stack");
    const std::vector<Handle> items(stack_.begin() + static_cast<std::ptrdiff_t>(marks_.back()), stack_.end());
    stack_.resize(marks_.back());
    marks_.pop_back();
    return items;
}

std::vector<Handle> PickleMachine::pop_many(std::size_t count)
{
    std::vector<Handle> items(count);
    for (std::size_t i = count; i-- > 0;)
        items[i] = pop();
    return items;
}

Node& PickleMachine::top()
{
    const Handle handle = pop();
    stack_.push_back(handle);
    return nodes_[handle];
}

void PickleMachine::extend(Node& container, const std::vector<Handle>& items)
{
    items_ += items.size();
    if (items_ > most_items)
        fail(operation_, fmt::format("containers with more than {} entries", most_items));
    container.items.insert(container.items.end(), items.begin(), items.end());
}

const Node& PickleMachine::run()
{
    start_ = position_;
    stack_.clear();
    marks_.clear();
    memo_.clear();
    for (;;)
    {
        operation_ = position_;
        const auto code = std::to_integer<std::uint8_t>(take(1)[0]);
        if (code == '.')
            break;
        run_operation(code);
    }
    if (stack_.size() != 1 || !marks_.empty())
        fail(operation_, "the pickle ends with more or less than one value");
    return nodes_[stack_.back()];
}

void PickleMachine::run_operation(std::uint8_t code)
{
    const auto push_tuple = [&](const std::vector<Handle>& items)
    {
        Node node{.kind = Kind::tuple};
        extend(node, items);
        push(std::move(node));
    };
    const auto append = [&](Kind kind, const std::vector<Handle>& items)
    {
        Node& container = top();
        if (container.kind != kind || (kind == Kind::dictionary && items.size() % 2 != 0))
            fail(operation_, "entries for something other than a container");
        extend(container, items);
    };
    switch (code)
    {
    case 0x80:  // PROTO
        if (const auto version = unsigned_number(1); operation_ != start_ || version < 2 || version > 5)
            fail(operation_, "protocol " + std::to_string(version));
        return;
    case 0x95:  // FRAME
        if (unsigned_number(8) > bytes_.size() - position_)
            fail(operation_, "a frame beyond the end");
        return;
    case 'N':
        return push(Node{});
    case 0x88:  // NEWTRUE
    case 0x89:  // NEWFALSE
        return push(Node{.kind = Kind::boolean, .integer = code == 0x88 ? 1 : 0});
    case 'J':  // BININT
        return push(Node{.kind = Kind::integer, .integer = static_cast<std::int32_t>(unsigned_number(4))});
    case 'K':  // BININT1
    case 'M':  // BININT2
        return push(Node{.kind = Kind::integer, .integer = static_cast<std::int64_t>(unsigned_number(code == 'K' ? 1 : 2))});
    case 0x8a:  // LONG1
        return long_integer(take(unsigned_number(1)));
    case 'G':  // BINFLOAT; no number that counts is one
        take(8);
        return push(Node{.kind = Kind::real});
    case 'X':  // BINUNICODE
    case 'T':  // BINSTRING, Python 2's
        return push(Node{.kind = Kind::text, .text = text(unsigned_number(4))});
    case 0x8c:  // SHORT_BINUNICODE
    case 'U':   // SHORT_BINSTRING, Python 2's
        return push(Node{.kind = Kind::text, .text = text(unsigned_number(1))});
    case 'q':  // BINPUT
    case 'r':  // LONG_BINPUT
        return remember(unsigned_number(code == 'q' ? 1 : 4));
    case 0x94:  // MEMOIZE
        return remember(memo_.size());
    case 'h':  // BINGET
    case 'j':  // LONG_BINGET
        return recall(unsigned_number(code == 'h' ? 1 : 4));
    case '(':
        return marks_.push_back(stack_.size());
    case ')':
        return push_tuple({});
    case 0x85:  // TUPLE1
    case 0x86:
    case 0x87:
        return push_tuple(pop_many(code - 0x84U));
    case 't':
        return push_tuple(pop_to_mark());
    case ']':
        return push(Node{.kind = Kind::list});
    case '}':
        return push(Node{.kind = Kind::dictionary});
    case 'a':
        return append(Kind::list, pop_many(1));
    case 'e':
        return append(Kind::list, pop_to_mark());
    case 's':
        return append(Kind::dictionary, pop_many(2));
    case 'u':
        return append(Kind::dictionary, pop_to_mark());
    case 'c':  // GLOBAL
    {
        const auto module = line();
        return push_global(module, line());
    }
    case 0x93:  // STACK_GLOBAL
    {
        const auto names = pop_many(2);
        return push_global(nodes_[names[0]].text, nodes_[names[1]].text);
    }
    case 'Q':
        return push_storage();
    case 'R':
        return reduce();
    case 0x81:
        return new_object();
    case 'b':
        return build();
    default:
        fail(operation_, fmt::format("the operation 0x{:02x} is not allowed", code));
    }
}

void PickleMachine::long_integer(std::span<const std::byte> digits)
{
    if (digits.size() > 8)
        return push(Node{.kind = Kind::large_integer, .text = {reinterpret_cast<const char*>(digits.data()), digits.size()}});
    const bool negative = !digits.empty() && (digits.back() & std::byte{0x80}) != std::byte{0};
    std::int64_t number = negative ? -1 : 0;
    std::memcpy(&number, digits.data(), digits.size());
    push(Node{.kind = Kind::integer, .integer = number});
}

void PickleMachine::remember(std::uint64_t slot)
{
    const Handle handle = pop();
    memo_[slot] = handle;
    stack_.push_back(handle);
}

void PickleMachine::recall(std::uint64_t slot)
{
    const auto found = memo_.find(slot);
    if (found == memo_.end())
        fail(operation_, fmt::format("slot {} of the memo is empty", slot));
    stack_.push_back(found->second);
}

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
            return push(Node{.kind = Kind::global, .global = known.global, .type = known.type});
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
        return ordered_dict(arguments);
    case Global::rebuild_tensor:
        return rebuild_tensor(arguments);
    case Global::rebuild_parameter:
        return push_parameter(arguments);
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
        if (nodes_[item].kind != Kind::integer || nodes_[item].integer < 0)
            fail(operation_, "a tensor whose shape is not a tuple of at most 8 numbers");
        result.push_back(nodes_[item].integer);
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

/// The tensor that a parameter is made of stands for it.
void PickleMachine::push_parameter(const Node& arguments)
{
    if (arguments.items.empty() || nodes_[arguments.items[0]].kind != Kind::tensor)
        fail(operation_, "a parameter without a tensor");
    stack_.push_back(arguments.items[0]);
}

/// Parameters as PyTorch before 0.2 wrote them: Parameter() or Parameter(tensor, …).
void PickleMachine::new_object()
{
    const Node arguments = pop_arguments();
    const Node& callable = nodes_[pop()];
    if (callable.kind != Kind::global || callable.global != Global::parameter)
        fail(operation_, "makes an object that no state dict needs");
    if (arguments.items.empty())
        return push(Node{.kind = Kind::parameter});
    push_parameter(arguments);
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
