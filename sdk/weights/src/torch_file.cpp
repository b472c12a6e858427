#include "pickle.h"

#include <fresco/error.h>
#include <fresco/zip.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// \file The two forms of torch.save: pickles with the storages behind them, and a zip archive with a pickle and an entry for
/// each storage.

namespace fresco::weights
{
namespace
{

using detail::Kind;
using detail::Node;
using detail::PickleMachine;
using detail::StoredTensor;

/// The tensors of a state dict whose storages have been found: the bytes of each are in `contents`. Throws Error through the
/// machine for an entry that is no tensor, a name that is there twice or no name.
std::vector<TensorView> tensors_of(const PickleMachine& machine, const Node& root,
                                   const std::vector<std::span<const std::byte>>& contents)
{
    const std::size_t end = machine.position();
    if (root.kind != Kind::dictionary)
        machine.fail(end, "the file holds no dict of tensors");
    std::vector<TensorView> result;
    std::set<std::string_view> names;
    for (std::size_t i = 0; i + 1 < root.items.size(); i += 2)
    {
        const Node& name = machine.node(root.items[i]);
        const Node& value = machine.node(root.items[i + 1]);
        const bool printable = std::ranges::all_of(name.text, [](char c) { return c >= 0x20 && c < 0x7f; });
        if (name.kind != Kind::text || name.text.empty() || !printable || !names.insert(name.text).second)
            machine.fail(end, "an entry without a name of its own");
        if (value.kind != Kind::tensor)
            machine.fail(end, "the entry '" + std::string(name.text) + "' is not a tensor");
        const StoredTensor& tensor = machine.tensors()[static_cast<std::size_t>(value.integer)];
        const ElementType type = machine.storages()[tensor.storage].type;
        result.push_back({std::string(name.text), type, tensor.shape,
                          contents[tensor.storage].subspan(tensor.offset * size_of(type), tensor.count * size_of(type))});
    }
    return result;
}

/// 0x1950a86a20f9469cfc6c
constexpr std::string_view magic_number = "\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19";
constexpr std::int64_t protocol_version = 1001;

void check_preamble(PickleMachine& machine)
{
    const Node magic = machine.run();
    if (magic.kind != Kind::large_integer || magic.text != magic_number)
        machine.fail(0, "the magic number of PyTorch's files is missing");
    const Node version = machine.run();
    if (version.kind != Kind::integer || version.integer != protocol_version)
        machine.fail(machine.position(), "the protocol is not 1001");
    const Node system = machine.run();
    if (system.kind != Kind::dictionary)
        machine.fail(machine.position(), "the description of the system is missing");
    for (std::size_t i = 0; i + 1 < system.items.size(); i += 2)
        if (machine.node(system.items[i]).text == "little_endian" && machine.node(system.items[i + 1]).integer != 1)
            machine.fail(machine.position(), "the numbers are big-endian");
}

}  // namespace

StateDict parse_legacy_pickle(std::span<const std::byte> bytes, std::string_view source)
{
    PickleMachine machine(bytes, source);
    check_preamble(machine);
    const Node root = machine.run();
    const Node keys = machine.run();
    if (keys.kind != Kind::list)
        machine.fail(machine.position(), "the list of storages is missing");

    const auto& storages = machine.storages();
    std::vector<std::span<const std::byte>> contents(storages.size());
    std::vector<bool> found(storages.size());
    std::size_t position = machine.position();
    for (const auto handle : keys.items)
    {
        const Node& key = machine.node(handle);
        const auto index =
            static_cast<std::size_t>(std::ranges::find(storages, key.text, &detail::Storage::key) - storages.begin());
        if (key.kind != Kind::text || index == storages.size() || found[index])
            machine.fail(position, "the list of storages does not fit the tensors");
        std::uint64_t count = 0;
        if (bytes.size() - position < sizeof count)
            machine.fail(position, "the file ends before a storage");
        std::memcpy(&count, bytes.data() + position, sizeof count);
        position += sizeof count;
        const std::size_t size = size_of(storages[index].type);
        if (count != storages[index].count || count > (bytes.size() - position) / size)
            machine.fail(position, fmt::format("a storage of {} elements; {} were announced, and there is room for {}", count,
                                               storages[index].count, (bytes.size() - position) / size));
        contents[index] = bytes.subspan(position, count * size);
        found[index] = true;
        position += count * size;
    }
    if (position != bytes.size())
        machine.fail(position, "bytes that belong to no storage");
    if (std::ranges::find(found, false) != found.end())
        machine.fail(position, "a storage is missing");

    StateDict result;
    result.form = Form::legacy_pickle;
    result.tensors = tensors_of(machine, root, contents);
    return result;
}

StateDict parse_zip_pickle(std::span<const std::byte> bytes, std::string_view source)
{
    const ZipReader archive(bytes, source);
    std::vector<std::string> pickles = archive.names();
    std::erase_if(pickles, [](const std::string& name) { return !name.ends_with("/data.pkl"); });
    if (pickles.size() != 1)
        throw Error(fmt::format("{}: {} that end with '/data.pkl'; not an archive as torch.save writes it", source,
                                pickles.empty() ? "no entries" : "two entries"));
    const std::string& name = pickles.front();
    const std::string folder = name.substr(0, name.size() - std::string_view("data.pkl").size());
    if (archive.contains(folder + "constants.pkl"))
        throw Error(std::string(source) +
                    ": is a TorchScript program, not a state dict; save model.state_dict() with torch.save");
    if (archive.contains(folder + "byteorder"))
    {
        const auto order = archive.contents(folder + "byteorder");
        if (std::string_view(reinterpret_cast<const char*>(order.data()), order.size()) != "little")
            throw Error(std::string(source) + ": the numbers are big-endian; save it on another machine");
    }

    const auto pickle = archive.contents(name);
    PickleMachine machine(pickle, std::string(source) + ": " + name);
    const detail::Node root = machine.run();
    if (machine.position() != pickle.size())
        machine.fail(machine.position(), "bytes after the pickle");
    std::vector<std::span<const std::byte>> contents;
    std::size_t all_bytes = 0;
    for (const auto& storage : machine.storages())
    {
        const std::string entry = folder + "data/" + std::string(storage.key);
        contents.push_back(archive.contents(entry));
        all_bytes += contents.back().size();
        if (all_bytes > bytes.size())
            throw Error(fmt::format("{}: entry '{}' overlaps another", source, entry));
        const std::size_t size = size_of(storage.type);
        if (contents.back().size() % size != 0 || contents.back().size() / size != storage.count)
            throw Error(fmt::format("{}: entry '{}' has {} bytes, not {} elements of {}", source, entry, contents.back().size(),
                                    storage.count, size));
    }
    StateDict result;
    result.form = Form::zip_pickle;
    result.tensors = tensors_of(machine, root, contents);
    return result;
}

}  // namespace fresco::weights
