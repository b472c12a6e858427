#pragma once

/// \file The part of Python's pickle language that state dicts are written in. Values are numbers into one list; "calls" are the
/// few that PyTorch writes, and make an entry of that list: there is nothing else that a stream could name or do.

#include <fresco/weights/state_dict.h>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::weights::detail
{

enum class Kind : std::uint8_t
{
    none,
    boolean,
    integer,
    large_integer,  ///< More than 64 bits: its bytes are `text`.
    real,
    text,
    tuple,
    list,
    dictionary,  ///< dict or OrderedDict: key, value, key, value, …
    global,
    storage,
    tensor,
    parameter  ///< An object that gets its tensor by BUILD.
};

enum class Global : std::uint8_t
{
    ordered_dict,
    rebuild_tensor,
    rebuild_parameter,
    parameter,
    storage_type
};

using Handle = std::uint32_t;

struct Node
{
    Kind kind = Kind::none;
    Global global = Global::ordered_dict;
    ElementType type = ElementType::float32;  ///< Element type of a storage.
    std::int64_t integer = 0;                 ///< Also: 0 or 1 for a boolean, an index for storages and tensors.
    std::string_view text{};
    std::vector<Handle> items{};
};

/// A block of elements that is written elsewhere in the file.
struct Storage
{
    std::string_view key;
    ElementType type = ElementType::float32;
    std::uint64_t count = 0;
};

/// A row-major piece of a storage.
struct StoredTensor
{
    std::size_t storage = 0;
    std::uint64_t offset = 0;  ///< In elements.
    std::vector<std::size_t> shape;
    std::uint64_t count = 0;
};

/// Runs one pickle after another over the same bytes; storages and tensors are gathered over all of them.
class PickleMachine
{
  public:
    PickleMachine(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source) {}

    /// Reads the pickle that begins at `position()`; returns its value. Throws Error naming source and offset.
    const Node& run();
    std::size_t position() const { return position_; }

    const Node& node(Handle handle) const { return nodes_[handle]; }
    const std::vector<Storage>& storages() const { return storages_; }
    const std::vector<StoredTensor>& tensors() const { return tensors_; }

    [[noreturn]] void fail(std::size_t offset, const std::string& what) const;

  private:
    void run_operation(std::uint8_t code);

    std::span<const std::byte> take(std::uint64_t count);
    std::uint64_t unsigned_number(std::size_t bytes);
    std::string_view text(std::uint64_t count);
    std::string_view line();

    void push(Node node);
    Handle pop();
    std::vector<Handle> pop_to_mark();
    std::vector<Handle> pop_many(std::size_t count);
    Node& top();
    /// Takes the arguments of a call, a tuple; a copy, because values are added meanwhile.
    Node pop_arguments();
    void extend(Node& container, const std::vector<Handle>& items);

    void long_integer(std::span<const std::byte> digits);
    void remember(std::uint64_t slot);
    void recall(std::uint64_t slot);
    void push_global(std::string_view module, std::string_view name);
    void push_storage();
    void reduce();
    void new_object();
    void push_parameter(const Node& arguments);
    void build();
    void ordered_dict(const Node& arguments);
    void rebuild_tensor(const Node& arguments);
    std::vector<std::int64_t> numbers(Handle tuple);

    std::span<const std::byte> bytes_;
    std::string source_;
    std::size_t position_ = 0;
    std::size_t start_ = 0;      ///< Start of this pickle.
    std::size_t operation_ = 0;  ///< Start of the current operation.
    std::size_t items_ = 0;      ///< In all containers.
    std::vector<Node> nodes_;
    std::vector<Handle> stack_;
    std::vector<std::size_t> marks_;
    std::map<std::uint64_t, Handle> memo_;  ///< By slot.
    std::vector<Storage> storages_;
    std::vector<StoredTensor> tensors_;
};

}  // namespace fresco::weights::detail
