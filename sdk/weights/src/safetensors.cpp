#include <fresco/weights/state_dict.h>

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/value.h>

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>
#include <utility>

namespace fresco::weights
{
namespace
{

/// Tens of thousands of tensors. Parsed, a header takes twenty-five times its size in memory.
constexpr std::size_t largest_header = std::size_t{4} << 20U;
constexpr std::size_t header_begin = 8;

class Reader
{
  public:
    Reader(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source) {}

    StateDict read()
    {
        const Value header = parse_header();
        StateDict contents;
        for (const auto& [name, entry] : JsonPlace(header, source_ + ": header").map())
            if (name != "__metadata__")
                contents.tensors.push_back(tensor(name, entry));
            else
                for (const auto& [key, text] : entry.map())
                    contents.metadata.emplace(key, text.text());
        // In the order in which they lie.
        std::ranges::sort(contents.tensors, {},
                          [](const TensorView& tensor) { return std::pair(tensor.bytes.data(), tensor.bytes.size()); });
        check_layout(contents.tensors);
        return contents;
    }

  private:
    [[noreturn]] void fail(std::size_t offset, const std::string& what) const
    {
        throw Error(fmt::format("{}: byte {}: {}; not a valid safetensors file", source_, offset, what));
    }

    Value parse_header()
    {
        if (bytes_.size() < header_begin)
            fail(0, "the file ends before its 8-byte header length");
        std::uint64_t length = 0;
        std::memcpy(&length, bytes_.data(), header_begin);
        if (length > largest_header)
            fail(0, fmt::format("a header of {} bytes is more than the 4 MiB allowed", length));
        if (length > bytes_.size() - header_begin)
            fail(0, fmt::format("a header of {} bytes in a file of {}", length, bytes_.size()));
        data_ = header_begin + static_cast<std::size_t>(length);
        const std::string_view text(reinterpret_cast<const char*>(bytes_.data()) + header_begin,
                                    static_cast<std::size_t>(length));
        if (text.empty() || text.front() != '{')
            fail(header_begin, "the header does not begin with '{'");
        return parse_json(text, source_ + ": header");
    }

    TensorView tensor(const std::string& name, const JsonPlace& entry) const
    {
        entry.has_only({"dtype", "shape", "data_offsets"});
        TensorView result{name, type_of(entry["dtype"]), {}, {}};
        std::size_t size = size_of(result.type);
        constexpr std::size_t most_dimensions = 64;
        const JsonPlace shape = entry["shape"];
        if (shape.value().is_list() && shape.value().as_list().size() > most_dimensions)
            shape.fail("has too many dimensions");
        for (const JsonPlace& extent : shape.list())
        {
            result.shape.push_back(static_cast<std::size_t>(extent.integer(0)));
            // A product that overflows could fit the offsets by accident; strides multiply an empty tensor's other extents too.
            const std::size_t factor = std::max<std::size_t>(result.shape.back(), 1);
            if (size > std::numeric_limits<std::size_t>::max() / 4 / factor)
                extent.fail("the shape is too large");
            size *= factor;
        }
        if (std::ranges::find(result.shape, 0U) != result.shape.end())
            size = 0;

        // From the first byte after the header.
        const auto offsets = entry["data_offsets"].list(2);
        const auto begin = static_cast<std::size_t>(offsets[0].integer(0));
        const auto end = static_cast<std::size_t>(offsets[1].integer(0));
        if (end < begin || end > bytes_.size() - data_)
            offsets[1].fail("beyond the end of the file");
        if (end - begin != size)
            entry.fail(fmt::format("the shape takes {} bytes, the data_offsets give {}", size, end - begin));
        result.bytes = bytes_.subspan(data_ + begin, size);
        return result;
    }

    static ElementType type_of(const JsonPlace& name)
    {
        // From the first of them to the last.
        for (auto type = ElementType::float64; type <= ElementType::boolean; type = ElementType{static_cast<int>(type) + 1})
            if (name_of(type) == name.text())
                return type;
        name.fail("unknown type '" + name.text() + "'");
    }

    /// The tensors must cover the bytes after the header once and without gaps: nothing is hidden between them.
    void check_layout(const std::vector<TensorView>& tensors) const
    {
        std::size_t position = data_;
        for (const auto& tensor : tensors)
        {
            const auto begin = static_cast<std::size_t>(tensor.bytes.data() - bytes_.data());
            if (begin != position)
                fail(std::min(begin, position),
                     "tensor '" + tensor.name + (begin < position ? "' overlaps the one before it" : "' leaves a gap before it"));
            position = begin + tensor.bytes.size();
        }
        if (position != bytes_.size())
            fail(position, "bytes that belong to no tensor");
    }

    std::span<const std::byte> bytes_;
    std::string source_;
    std::size_t data_ = 0;  ///< Offset of the tensors.
};

std::string header_of(std::span<const TensorView* const> tensors, const std::map<std::string, std::string>& metadata)
{
    Value header{Value::Map{}};
    if (!metadata.empty())
        header.set("__metadata__", Value::Map(metadata.begin(), metadata.end()));
    std::size_t position = 0;
    for (const auto* tensor : tensors)
    {
        const std::size_t end = position + tensor->bytes.size();
        header.set(tensor->name, Value::Map{{"dtype", name_of(tensor->type)},
                                            {"shape", Value::List(tensor->shape.begin(), tensor->shape.end())},
                                            {"data_offsets", Value::List{position, end}}});
        position = end;
    }
    std::string text = to_json(header);
    text.append((8 - text.size() % 8) % 8, ' ');
    return text;
}

/// The bytes of a file: its head, which they refer to, and the tensors' own.
std::vector<std::span<const std::byte>> pieces(std::span<const TensorView> tensors,
                                               const std::map<std::string, std::string>& metadata, std::vector<std::byte>& head)
{
    std::vector<const TensorView*> ordered;
    for (const auto& tensor : tensors)
    {
        std::size_t size = size_of(tensor.type);
        for (const std::size_t extent : tensor.shape)
            size *= extent;
        if (tensor.name == "__metadata__" || size != tensor.bytes.size())
            throw std::invalid_argument("to_safetensors: tensor '" + tensor.name +
                                        "' has a reserved name or bytes that do not fit");
        ordered.push_back(&tensor);
    }
    std::ranges::stable_sort(ordered, {}, &TensorView::type);
    const std::string header = header_of(ordered, metadata);
    head.resize(header_begin + header.size());
    const std::uint64_t length = header.size();
    std::memcpy(head.data(), &length, header_begin);
    std::memcpy(head.data() + header_begin, header.data(), header.size());
    std::vector<std::span<const std::byte>> result{head};
    for (const auto* tensor : ordered)
        result.push_back(tensor->bytes);
    return result;
}

}  // namespace

StateDict parse_safetensors(std::span<const std::byte> bytes, std::string_view source)
{
    return Reader(bytes, source).read();
}

std::vector<std::byte> to_safetensors(std::span<const TensorView> tensors, const std::map<std::string, std::string>& metadata)
{
    std::vector<std::byte> head;
    std::vector<std::byte> bytes;
    for (const auto piece : pieces(tensors, metadata, head))
        bytes.insert(bytes.end(), piece.begin(), piece.end());
    return bytes;
}

void write_safetensors(const std::filesystem::path& file, std::span<const TensorView> tensors,
                       const std::map<std::string, std::string>& metadata)
{
    std::vector<std::byte> head;
    write_durable_file(file, pieces(tensors, metadata, head));
}

}  // namespace fresco::weights
