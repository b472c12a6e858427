#include "pickle.h"

#include <fresco/error.h>

#include <zlib.h>

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

constexpr std::size_t end_size = 22;
constexpr std::size_t directory_entry_size = 46;
constexpr std::size_t header_size = 30;
constexpr std::uint64_t encrypted = 1;
constexpr std::uint64_t sizes_follow = 8;  ///< The sizes are after the data, not in the entry's header.

bool saturated(std::uint64_t number)
{
    return number == 0xffffffffU;
}

/// The entries of a zip archive whose entries are stored, not compressed, as PyTorch writes them. The central directory decides;
/// each entry's own header must agree with it, and no two may overlap.
class ZipArchive
{
  public:
    /// Throws Error naming source and offset.
    ZipArchive(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source)
    {
        const std::size_t end = find_end();
        const std::uint64_t count = number(end + 10, 2);
        const std::uint64_t size = number(end + 12, 4);
        const std::uint64_t begin = number(end + 16, 4);
        if (number(end + 4, 4) != 0 || number(end + 8, 2) != count)
            fail(end, "an archive in several parts");
        if (saturated(size) || saturated(begin) || begin > end || size > end - begin)
            fail(end, "a central directory beyond the end of the file");
        std::size_t offset = static_cast<std::size_t>(begin);
        for (std::uint64_t i = 0; i < count; ++i)
            offset = read_entry(offset, static_cast<std::size_t>(begin + size));
        if (offset != begin + size)
            fail(offset, "bytes in the central directory that belong to no entry");
        check_overlaps(static_cast<std::size_t>(begin));
    }

    /// The contents, compared with their checksum. Throws Error if there is no such entry or it is damaged.
    std::span<const std::byte> contents(const std::string& name) const
    {
        const auto found = entries_.find(name);
        if (found == entries_.end())
            throw Error(source_ + ": the archive lacks the entry '" + name + "'");
        const auto data = bytes_.subspan(found->second.data, found->second.size);
        if (crc32_z(0, reinterpret_cast<const Bytef*>(data.data()), data.size()) != found->second.checksum)
            fail(found->second.data, "the entry '" + name + "' is damaged: its checksum is wrong");
        return data;
    }

    bool contains(const std::string& name) const { return entries_.contains(name); }
    /// The name of the one entry that ends so. Throws Error unless there is exactly one.
    std::string only_name_with_end(std::string_view end) const
    {
        std::string result;
        for (const auto& [name, entry] : entries_)
            if (name.ends_with(end))
            {
                if (!result.empty())
                    throw Error(source_ + ": two entries that end with '" + std::string(end) + "'");
                result = name;
            }
        if (result.empty())
            throw Error(source_ + ": no entry that ends with '" + std::string(end) + "'; not an archive as torch.save writes it");
        return result;
    }

  private:
    struct Entry
    {
        std::size_t header = 0;
        std::size_t data = 0;
        std::size_t size = 0;
        std::uint32_t checksum = 0;
    };

    [[noreturn]] void fail(std::size_t offset, const std::string& what) const
    {
        throw Error(fmt::format("{}: byte {}: {}; not a zip archive as torch.save writes it", source_, offset, what));
    }

    std::uint64_t number(std::size_t offset, std::size_t bytes) const
    {
        std::uint64_t value = 0;
        std::memcpy(&value, bytes_.data() + offset, bytes);
        return value;
    }

    std::size_t find_end() const
    {
        constexpr std::size_t longest_comment = 0xffff;
        const std::size_t size = bytes_.size();
        for (std::size_t comment = 0; comment <= longest_comment && comment + end_size <= size; ++comment)
        {
            const std::size_t at = size - end_size - comment;
            if (std::memcmp(bytes_.data() + at, "PK\5\6", 4) == 0 && number(at + 20, 2) == comment)
                return at;
        }
        fail(size, "the end of the central directory is missing: the file is cut off");
    }

    std::size_t read_entry(std::size_t offset, std::size_t end)
    {
        if (end - offset < directory_entry_size || std::memcmp(bytes_.data() + offset, "PK\1\2", 4) != 0)
            fail(offset, "an entry of the central directory is missing");
        const std::uint64_t flags = number(offset + 8, 2);
        const std::uint64_t method = number(offset + 10, 2);
        const std::uint64_t packed = number(offset + 20, 4);
        const std::uint64_t size = number(offset + 24, 4);
        const std::uint64_t name_length = number(offset + 28, 2);
        const std::uint64_t length = directory_entry_size + name_length + number(offset + 30, 2) + number(offset + 32, 2);
        const std::uint64_t header = number(offset + 42, 4);
        if (length > end - offset)
            fail(offset, "an entry of the central directory is cut off");
        const std::string name(reinterpret_cast<const char*>(bytes_.data()) + offset + directory_entry_size, name_length);
        if ((flags & encrypted) != 0 || method != 0)
            fail(offset, "an entry that is compressed or encrypted; PyTorch stores them as they are");
        if (saturated(size) || saturated(header) || packed != size)
            fail(offset, "an entry of more than 4 GiB or with two sizes");
        Entry entry{static_cast<std::size_t>(header), 0, static_cast<std::size_t>(size),
                    static_cast<std::uint32_t>(number(offset + 16, 4))};
        check_header(name, entry);
        if (!entries_.emplace(name, entry).second)
            fail(offset, "two entries of the same name");
        return offset + static_cast<std::size_t>(length);
    }

    void check_header(const std::string& name, Entry& entry) const
    {
        const std::size_t at = entry.header;
        if (at > bytes_.size() || bytes_.size() - at < header_size || std::memcmp(bytes_.data() + at, "PK\3\4", 4) != 0)
            fail(at, "the header of an entry is missing");
        const std::uint64_t flags = number(at + 6, 2);
        const std::uint64_t name_length = number(at + 26, 2);
        const std::uint64_t length = header_size + name_length + number(at + 28, 2);
        if (length > bytes_.size() - at || entry.size > bytes_.size() - at - length)
            fail(at, "an entry beyond the end of the file");
        const bool has_sizes = (flags & sizes_follow) == 0;
        if (number(at + 8, 2) != 0 || name_length != name.size() ||
            std::memcmp(bytes_.data() + at + header_size, name.data(), name.size()) != 0 ||
            (has_sizes && (number(at + 14, 4) != entry.checksum || number(at + 22, 4) != entry.size)))
            fail(at, "the header of an entry does not agree with the central directory");
        entry.data = at + static_cast<std::size_t>(length);
    }

    void check_overlaps(std::size_t directory) const
    {
        std::vector<std::pair<std::size_t, std::size_t>> extents;
        for (const auto& [name, entry] : entries_)
            extents.emplace_back(entry.header, entry.data + entry.size);
        std::ranges::sort(extents);
        std::size_t previous = 0;
        for (const auto& [begin, end] : extents)
        {
            if (begin < previous || end > directory)
                fail(begin, "entries that overlap");
            previous = end;
        }
    }

    std::span<const std::byte> bytes_;
    std::string source_;
    std::map<std::string, Entry> entries_;
};

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
    const ZipArchive archive(bytes, source);
    const std::string name = archive.only_name_with_end("/data.pkl");
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
    for (const auto& storage : machine.storages())
    {
        const std::string entry = folder + "data/" + std::string(storage.key);
        contents.push_back(archive.contents(entry));
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
