#include "pickle_machine.h"

#include <fresco/error.h>

#include <array>
#include <cstring>
#include <fmt/format.h>
#include <utility>

namespace fresco::weights::detail
{
namespace
{

// A state dict of VGG-19 takes about 1 000 operations.
constexpr std::size_t most_operations = 1'000'000;
constexpr std::size_t most_nodes = 250'000;
constexpr std::size_t most_items = 1'000'000;
constexpr std::size_t most_on_stack = 100'000;
constexpr std::size_t most_marks = 64;
constexpr std::size_t most_slots = 100'000;
constexpr std::size_t most_levels = 64;
constexpr std::size_t longest_text = 4096;
constexpr std::size_t longest_pickle = std::size_t{16} << 20U;
constexpr Handle nowhere = ~Handle{0};

std::string code_text(std::uint8_t code)
{
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text = "0x";
    text += digits[code >> 4U];
    text += digits[code & 15U];
    return text;
}

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
        fail(operation_, "a pickle of more than 16 MiB");
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

Handle PickleMachine::make(Node node)
{
    if (nodes_.size() >= most_nodes)
        fail(operation_, fmt::format("more than {} values", most_nodes));
    nodes_.push_back(std::move(node));
    return static_cast<Handle>(nodes_.size() - 1);
}

void PickleMachine::push(Handle handle)
{
    if (stack_.size() >= most_on_stack)
        fail(operation_, fmt::format("more than {} values on the stack", most_on_stack));
    stack_.push_back(handle);
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
    for (const Handle item : items)
    {
        const std::size_t depth = std::size_t{nodes_[item].depth} + 1;
        if (depth > most_levels)
            fail(operation_, fmt::format("values nested in more than {} levels", most_levels));
        if (depth > container.depth)
            container.depth = static_cast<std::uint16_t>(depth);
        container.items.push_back(item);
    }
}

const Node& PickleMachine::run()
{
    start_ = position_;
    stack_.clear();
    marks_.clear();
    memo_.clear();
    while (step())
        if (++operations_ > most_operations)
            fail(operation_, fmt::format("more than {} operations", most_operations));
    if (stack_.size() != 1 || !marks_.empty())
        fail(operation_, "the pickle ends with more or less than one value");
    return nodes_[stack_.back()];
}

bool PickleMachine::step()
{
    operation_ = position_;
    const auto code = std::to_integer<std::uint8_t>(take(1)[0]);
    if (code == '.')
        return false;
    if (!step_constant(code) && !step_memory(code) && !step_container(code) && !step_call(code))
        fail(operation_, "the operation " + code_text(code) + " is not allowed");
    return true;
}

bool PickleMachine::step_constant(std::uint8_t code)
{
    switch (code)
    {
    case 0x80:  // PROTO
        if (const auto version = unsigned_number(1); operation_ != start_ || version < 2 || version > 5)
            fail(operation_, "protocol " + std::to_string(version));
        return true;
    case 0x95:  // FRAME
        if (unsigned_number(8) > bytes_.size() - position_)
            fail(operation_, "a frame beyond the end");
        return true;
    case 'N':
        push(Node{});
        return true;
    case 0x88:  // NEWTRUE
    case 0x89:  // NEWFALSE
        push(Node{.kind = Kind::boolean, .integer = code == 0x88 ? 1 : 0});
        return true;
    case 'J':  // BININT
        push(Node{.kind = Kind::integer, .integer = static_cast<std::int32_t>(unsigned_number(4))});
        return true;
    case 'K':  // BININT1
    case 'M':  // BININT2
        push(Node{.kind = Kind::integer, .integer = static_cast<std::int64_t>(unsigned_number(code == 'K' ? 1 : 2))});
        return true;
    case 0x8a:  // LONG1
        long_integer(take(unsigned_number(1)));
        return true;
    case 'G':  // BINFLOAT; no number that counts is one
        take(8);
        push(Node{.kind = Kind::real});
        return true;
    case 'X':  // BINUNICODE
    case 'T':  // BINSTRING, Python 2's
        push(Node{.kind = Kind::text, .text = text(unsigned_number(4))});
        return true;
    case 0x8c:  // SHORT_BINUNICODE
    case 'U':   // SHORT_BINSTRING, Python 2's
        push(Node{.kind = Kind::text, .text = text(unsigned_number(1))});
        return true;
    default:
        return false;
    }
}

bool PickleMachine::step_memory(std::uint8_t code)
{
    switch (code)
    {
    case 'q':  // BINPUT
    case 'r':  // LONG_BINPUT
        remember(unsigned_number(code == 'q' ? 1 : 4));
        return true;
    case 0x94:  // MEMOIZE
        remember(memo_.size());
        return true;
    case 'h':  // BINGET
    case 'j':  // LONG_BINGET
        recall(unsigned_number(code == 'h' ? 1 : 4));
        return true;
    case '(':
        if (marks_.size() >= most_marks)
            fail(operation_, fmt::format("more than {} marks", most_marks));
        marks_.push_back(stack_.size());
        return true;
    default:
        return false;
    }
}

bool PickleMachine::step_container(std::uint8_t code)
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
    case ')':
        push_tuple({});
        return true;
    case 0x85:  // TUPLE1
    case 0x86:
    case 0x87:
        push_tuple(pop_many(code - 0x84U));
        return true;
    case 't':
        push_tuple(pop_to_mark());
        return true;
    case ']':
        push(Node{.kind = Kind::list});
        return true;
    case '}':
        push(Node{.kind = Kind::dictionary});
        return true;
    case 'a':
        append(Kind::list, pop_many(1));
        return true;
    case 'e':
        append(Kind::list, pop_to_mark());
        return true;
    case 's':
        append(Kind::dictionary, pop_many(2));
        return true;
    case 'u':
        append(Kind::dictionary, pop_to_mark());
        return true;
    default:
        return false;
    }
}

bool PickleMachine::step_call(std::uint8_t code)
{
    switch (code)
    {
    case 'c':  // GLOBAL
    {
        const auto module = line();
        push_global(module, line());
        return true;
    }
    case 0x93:  // STACK_GLOBAL
    {
        const auto names = pop_many(2);
        push_global(nodes_[names[0]].text, nodes_[names[1]].text);
        return true;
    }
    case 'Q':
        push_storage();
        return true;
    case 'R':
        reduce();
        return true;
    case 0x81:
        new_object();
        return true;
    case 'b':
        build();
        return true;
    default:
        return false;
    }
}

void PickleMachine::long_integer(std::span<const std::byte> digits)
{
    if (digits.size() > 8)
    {
        push(Node{.kind = Kind::large_integer, .text = {reinterpret_cast<const char*>(digits.data()), digits.size()}});
        return;
    }
    const bool negative = !digits.empty() && (digits.back() & std::byte{0x80}) != std::byte{0};
    std::int64_t number = negative ? -1 : 0;
    std::memcpy(&number, digits.data(), digits.size());
    push(Node{.kind = Kind::integer, .integer = number});
}

void PickleMachine::remember(std::uint64_t slot)
{
    if (slot >= most_slots)
        fail(operation_, fmt::format("slot {} of the memo", slot));
    if (slot >= memo_.size())
        memo_.resize(static_cast<std::size_t>(slot) + 1, nowhere);
    const Handle handle = pop();
    memo_[static_cast<std::size_t>(slot)] = handle;
    stack_.push_back(handle);
}

void PickleMachine::recall(std::uint64_t slot)
{
    if (slot >= memo_.size() || memo_[static_cast<std::size_t>(slot)] == nowhere)
        fail(operation_, fmt::format("slot {} of the memo is empty", slot));
    push(memo_[static_cast<std::size_t>(slot)]);
}

}  // namespace fresco::weights::detail
