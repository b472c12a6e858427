#include <fresco/torch/tensor.h>

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <ATen/ops/empty.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace fresco
{
namespace
{

static_assert(std::endian::native == std::endian::little, "safetensors files are little-endian and read as they lie");

constexpr std::size_t largest_header = std::size_t{100} << 20U;
constexpr std::size_t prefix = 8;

struct TypeName
{
    at::ScalarType type;
    std::string_view name;
    bool written;
};
constexpr std::array<TypeName, 10> type_names{{{at::kDouble, "F64", true},
                                               {at::kLong, "I64", true},
                                               {at::kFloat, "F32", true},
                                               {at::kInt, "I32", true},
                                               {at::kHalf, "F16", false},
                                               {at::kBFloat16, "BF16", false},
                                               {at::kShort, "I16", false},
                                               {at::kByte, "U8", true},
                                               {at::kChar, "I8", false},
                                               {at::kBool, "BOOL", true}}};

/// What the header says of one tensor; `begin` and `end` count from the first byte after the header.
struct Entry
{
    std::string name;
    at::ScalarType type = at::kFloat;
    std::vector<std::int64_t> shape;
    std::size_t begin = 0;
    std::size_t end = 0;
};

class Reader
{
  public:
    explicit Reader(const std::filesystem::path& file) : file_(file.string()), bytes_(read_file(file)) {}

    SafeTensors read()
    {
        const Value header = parse_header();
        SafeTensors contents;
        std::vector<Entry> entries;
        for (const auto& [name, value] : header.as_map())
        {
            if (name == "__metadata__")
                contents.metadata = metadata(value);
            else
                entries.push_back(entry(name, value));
        }
        check_layout(entries);
        for (const auto& e : entries)
            contents.tensors.emplace(e.name, tensor(e));
        return contents;
    }

  private:
    [[noreturn]] void fail(std::size_t offset, const std::string& what) const
    {
        throw Error(file_ + ": byte " + std::to_string(offset) + ": " + what + "; this is no valid safetensors file");
    }

    Value parse_header()
    {
        if (bytes_.size() < prefix)
            fail(0, "the file ends before its 8-byte header length");
        std::uint64_t length = 0;
        std::memcpy(&length, bytes_.data(), prefix);
        if (length > largest_header)
            fail(0, "a header of " + std::to_string(length) + " bytes is more than the 100 MiB allowed");
        if (length > bytes_.size() - prefix)
            fail(0, "a header of " + std::to_string(length) + " bytes in a file of " + std::to_string(bytes_.size()));
        data_ = prefix + static_cast<std::size_t>(length);
        const std::string_view text(reinterpret_cast<const char*>(bytes_.data()) + prefix, static_cast<std::size_t>(length));
        if (text.empty() || text.front() != '{')
            fail(prefix, "the header does not begin with '{'");
        Value header = parse_json(text, file_ + ": header");
        if (!header.is_map())
            fail(prefix, "the header is no map");
        return header;
    }

    std::map<std::string, std::string> metadata(const Value& value) const
    {
        if (!value.is_map())
            fail(prefix, "__metadata__ is no map");
        std::map<std::string, std::string> result;
        for (const auto& [key, text] : value.as_map())
        {
            if (!text.is_string())
                fail(prefix, "__metadata__ '" + key + "' is no text");
            result.emplace(key, text.as_string());
        }
        return result;
    }

    std::size_t whole_number(const Value& value, const std::string& where) const
    {
        if (!value.is_int() || value.as_int() < 0)
            fail(prefix, where + ": expected a whole number of at least 0");
        return static_cast<std::size_t>(value.as_int());
    }

    Entry entry(const std::string& name, const Value& value) const
    {
        const std::string where = "tensor '" + name + "'";
        const Value* type = value.find("dtype");
        const Value* shape = value.find("shape");
        const Value* offsets = value.find("data_offsets");
        if (type == nullptr || shape == nullptr || offsets == nullptr || value.as_map().size() != 3 || !type->is_string() ||
            !shape->is_list() || !offsets->is_list() || offsets->as_list().size() != 2)
            fail(prefix, where + ": expected exactly dtype, shape and two data_offsets");
        Entry result;
        result.name = name;
        result.type = type_of(type->as_string(), where);
        std::size_t size = at::elementSize(result.type);
        for (const auto& extent : shape->as_list())
        {
            const std::size_t count = whole_number(extent, where + ": shape");
            // A product that overflows could fit the offsets by accident.
            if (count != 0 && size > std::numeric_limits<std::size_t>::max() / 4 / count)
                fail(prefix, where + ": the shape is too large");
            size *= count;
            result.shape.push_back(static_cast<std::int64_t>(count));
        }
        result.begin = whole_number(offsets->as_list()[0], where + ": data_offsets");
        result.end = whole_number(offsets->as_list()[1], where + ": data_offsets");
        if (result.end < result.begin || result.end > bytes_.size() - data_)
            fail(data_ + std::min(result.begin, bytes_.size()), where + ": data_offsets beyond the end of the file");
        if (result.end - result.begin != size)
            fail(data_ + result.begin, where + ": the shape takes " + std::to_string(size) + " bytes, the data_offsets give " +
                                           std::to_string(result.end - result.begin));
        return result;
    }

    at::ScalarType type_of(const std::string& name, const std::string& where) const
    {
        for (const auto& known : type_names)
            if (known.name == name)
                return known.type;
        fail(prefix, where + ": unknown type '" + name + "'");
    }

    /// The tensors must cover the bytes after the header once and without gaps: nothing is hidden between them.
    void check_layout(std::vector<Entry>& entries) const
    {
        std::sort(entries.begin(), entries.end(),
                  [](const Entry& a, const Entry& b) { return std::pair(a.begin, a.end) < std::pair(b.begin, b.end); });
        std::size_t position = 0;
        for (const auto& e : entries)
        {
            if (e.begin != position)
                fail(data_ + std::min(e.begin, position),
                     "tensor '" + e.name + (e.begin < position ? "' overlaps the one before it" : "' leaves a gap before it"));
            position = e.end;
        }
        if (data_ + position != bytes_.size())
            fail(data_ + position, "bytes that belong to no tensor");
    }

    torch::Tensor tensor(const Entry& e) const
    {
        auto result = at::empty(e.shape, e.type);
        const auto source = std::span(bytes_).subspan(data_ + e.begin, e.end - e.begin);
        if (e.type == at::kBool)
            for (std::size_t i = 0; i < source.size(); ++i)
                if (std::to_integer<unsigned>(source[i]) > 1)
                    fail(data_ + e.begin + i, "tensor '" + e.name + "': a BOOL that is neither 0 nor 1");
        if (!source.empty())
            std::memcpy(result.data_ptr(), source.data(), source.size());
        return result;
    }

    std::string file_;
    std::vector<std::byte> bytes_;
    std::size_t data_ = 0;  ///< Where the tensors begin.
};

struct Written
{
    std::string name;
    torch::Tensor tensor;
    std::size_t type = 0;  ///< Index into type_names, which are in descending order of size: so every tensor is aligned.
};

std::size_t written_type(const std::string& name, const torch::Tensor& tensor)
{
    for (std::size_t i = 0; i < type_names.size(); ++i)
        if (type_names[i].type == tensor.scalar_type() && type_names[i].written)
            return i;
    throw std::invalid_argument("write_safetensors: tensor '" + name + "' has a type that is not written");
}

}  // namespace

SafeTensors read_safetensors(const std::filesystem::path& file)
{
    return Reader(file).read();
}

void write_safetensors(const std::filesystem::path& file, const SafeTensors& contents)
{
    std::vector<Written> tensors;
    for (const auto& [name, tensor] : contents.tensors)
    {
        if (name == "__metadata__")
            throw std::invalid_argument("write_safetensors: no tensor may be named __metadata__");
        tensors.push_back({name, tensor.detach().to(at::kCPU).contiguous(), written_type(name, tensor)});
    }
    std::stable_sort(tensors.begin(), tensors.end(), [](const Written& a, const Written& b) { return a.type < b.type; });

    Value header{Value::Map{}};
    if (!contents.metadata.empty())
    {
        Value metadata{Value::Map{}};
        for (const auto& [key, text] : contents.metadata)
            metadata.set(key, text);
        header.set("__metadata__", std::move(metadata));
    }
    std::size_t position = 0;
    for (const auto& written : tensors)
    {
        Value::List shape;
        for (const auto extent : written.tensor.sizes())
            shape.emplace_back(std::int64_t{extent});
        const std::size_t size = written.tensor.nbytes();
        Value entry{Value::Map{}};
        entry.set("dtype", std::string(type_names[written.type].name));
        entry.set("shape", std::move(shape));
        entry.set("data_offsets", Value::List{Value(position), Value(position + size)});
        header.set(written.name, std::move(entry));
        position += size;
    }
    std::string text = to_json(header);
    text.append((8 - text.size() % 8) % 8, ' ');

    std::vector<std::byte> bytes(prefix + text.size() + position);
    const std::uint64_t length = text.size();
    std::memcpy(bytes.data(), &length, prefix);
    std::memcpy(bytes.data() + prefix, text.data(), text.size());
    std::size_t offset = prefix + text.size();
    for (const auto& written : tensors)
    {
        const std::size_t size = written.tensor.nbytes();
        if (size > 0)
            std::memcpy(bytes.data() + offset, written.tensor.data_ptr(), size);
        offset += size;
    }
    write_file(file, bytes);
}

}  // namespace fresco
