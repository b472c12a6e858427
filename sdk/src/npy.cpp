#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <regex>
#include <string>
#include <type_traits>

namespace fresco
{
namespace
{

struct TypeForm
{
    NpyType type;
    char kind;
    std::size_t bytes;

    std::string descr() const { return fmt::format("'{}{}{}'", bytes == 1 ? '|' : '<', kind, bytes); }
    std::string name() const { return fmt::format("{}{}", kind == 'f' ? "float" : kind == 'i' ? "int" : "uint", 8 * bytes); }
};

constexpr std::array<TypeForm, 7> type_forms{{{NpyType::uint8, 'u', 1},
                                              {NpyType::uint16, 'u', 2},
                                              {NpyType::uint32, 'u', 4},
                                              {NpyType::int32, 'i', 4},
                                              {NpyType::int64, 'i', 8},
                                              {NpyType::float32, 'f', 4},
                                              {NpyType::float64, 'f', 8}}};

const TypeForm& form_of(NpyType type)
{
    return *std::ranges::find(type_forms, type, &TypeForm::type);
}

template <class T>
const TypeForm& form_of()
{
    constexpr char kind = std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u';
    return *std::ranges::find_if(type_forms, [](const TypeForm& form) { return form.kind == kind && form.bytes == sizeof(T); });
}

constexpr std::string_view magic("\x93NUMPY", 6);
/// A regular expression takes stack for each character: what lies behind is not looked at.
constexpr std::size_t longest_header = 1024;
constexpr std::size_t most_extents = 8;

/// The value of `key` in the Python dictionary of a header, spelled as `form` says. Nothing but the spelling is checked.
std::csub_match value_in(std::string_view header, const std::string& key, const std::string& form)
{
    std::cmatch match;
    std::regex_search(header.data(), header.data() + header.size(), match, std::regex("'" + key + "' *: *(" + form + ")"));
    return match.empty() ? std::csub_match() : match[1];
}

/// Number of elements, or nothing if it does not fit.
bool product(std::span<const std::size_t> shape, std::size_t& count)
{
    count = 1;
    for (const std::size_t extent : shape)
        if (__builtin_mul_overflow(count, extent, &count))
            return false;
    return true;
}

/// Elements of `size` bytes whose first index changes fastest, reordered so that the last one does.
std::vector<std::byte> in_c_order(std::span<const std::byte> bytes, std::span<const std::size_t> shape, std::size_t size)
{
    std::vector<std::byte> result(bytes.size());
    std::vector<std::size_t> at(shape.size(), 0);
    for (std::size_t to = 0; to < bytes.size(); to += size)
    {
        std::size_t from = 0;
        for (std::size_t axis = shape.size(); axis-- > 0;)
            from = from * shape[axis] + at[axis];
        std::memcpy(result.data() + to, bytes.data() + from * size, size);
        for (std::size_t axis = shape.size(); axis-- > 0 && ++at[axis] == shape[axis];)
            at[axis] = 0;
    }
    return result;
}

}  // namespace

std::size_t NpyArray::count() const
{
    return bytes.size() / form_of(type).bytes;
}

template <class T>
std::span<const T> NpyArray::as() const
{
    if (type != form_of<T>().type)
        throw Error("array of type " + form_of(type).name() + "; expected " + form_of<T>().name());
    // The bytes come from operator new, aligned for every element type.
    return {reinterpret_cast<const T*>(bytes.data()), count()};
}

template std::span<const std::uint8_t> NpyArray::as() const;
template std::span<const std::uint16_t> NpyArray::as() const;
template std::span<const std::uint32_t> NpyArray::as() const;
template std::span<const std::int32_t> NpyArray::as() const;
template std::span<const std::int64_t> NpyArray::as() const;
template std::span<const float> NpyArray::as() const;
template std::span<const double> NpyArray::as() const;

NpyArray parse_npy(std::span<const std::byte> bytes, std::string_view source)
{
    const auto fail = [&](std::size_t offset, const std::string& what)
    { throw Error(fmt::format("{}: byte {}: {}", source, offset, what)); };
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (!text.starts_with(magic))
        fail(0, "not an NPY file: the magic \\x93NUMPY is missing");
    if (text.size() < 10)
        fail(text.size(), "the file is cut inside its header");
    const auto version = static_cast<unsigned char>(text[6]);
    if (version < 1 || version > 3)
        fail(6, fmt::format("NPY version {} is not supported (1 to 3 are)", version));
    const std::size_t length_bytes = version == 1 ? 2 : 4;
    const std::size_t header_begin = 8 + length_bytes;
    std::size_t header_size = 0;
    for (std::size_t i = 0; i < length_bytes && 8 + i < text.size(); ++i)
        header_size |= static_cast<std::size_t>(static_cast<unsigned char>(text[8 + i])) << (8 * i);
    if (text.size() < header_begin || header_size > text.size() - header_begin)
        fail(text.size(), "the file is cut inside its header");

    const std::string_view header = text.substr(header_begin, std::min(header_size, longest_header));
    const auto descr = value_in(header, "descr", "'[^']*'");
    const auto order = value_in(header, "fortran_order", "True|False");
    const auto shape = value_in(header, "shape", "\\([^()]*\\)");
    if (!descr.matched || !order.matched || !shape.matched)
        fail(header_begin, "expected a header such as {'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }");
    const auto place = [&](const char* in_header) { return static_cast<std::size_t>(in_header - text.data()); };
    const auto form = std::ranges::find(type_forms, descr.str(), &TypeForm::descr);
    if (form == type_forms.end())
        fail(place(descr.first),
             "element type not supported; save it as uint8, uint16, uint32, int32, int64, float32 or float64, little-endian");
    NpyArray array{.type = form->type, .shape = {}, .bytes = {}};
    const auto next = [&](const char* at) { return std::find_if(at, shape.second, [](char c) { return c != ',' && c != ' '; }); };
    for (const char* at = next(shape.first + 1); *at != ')';)
    {
        const auto [end, error] = std::from_chars(at, shape.second, array.shape.emplace_back());
        if (error != std::errc{} || array.shape.size() > most_extents)
            fail(place(at), "expected at most 8 numbers of rows, columns or channels");
        at = next(end);
    }
    const std::size_t data_begin = header_begin + header_size;
    std::size_t expected = 0;
    if (!product(array.shape, expected) || __builtin_mul_overflow(expected, form_of(array.type).bytes, &expected))
        fail(header_begin, "the shape is too large");
    if (bytes.size() - data_begin != expected)
        fail(bytes.size(),
             fmt::format("the shape asks for {} bytes of data, the file has {}", expected, bytes.size() - data_begin));
    array.bytes.assign(bytes.begin() + static_cast<std::ptrdiff_t>(data_begin), bytes.end());
    if (order.str() == "True")
        array.bytes = in_c_order(array.bytes, array.shape, form_of(array.type).bytes);
    return array;
}

NpyArray read_npy(const std::filesystem::path& file)
{
    return parse_npy(read_file(file), file.string());
}

std::vector<std::byte> to_npy(NpyType type, std::span<const std::size_t> shape, std::span<const std::byte> bytes)
{
    std::size_t expected = 0;
    if (!product(shape, expected) || expected * form_of(type).bytes != bytes.size())
        throw Error("to_npy: the shape does not fit the number of values");
    std::string header = "{'descr': " + form_of(type).descr() + ", 'fortran_order': False, 'shape': (";
    header += fmt::format("{}{}), }}", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
    // The data begins at a multiple of 64 bytes, as NumPy writes it.
    const std::size_t prefix = magic.size() + 4;
    header.append(63 - (prefix + header.size()) % 64, ' ');
    header += '\n';

    std::vector<std::byte> file(prefix + header.size() + bytes.size());
    std::memcpy(file.data(), magic.data(), magic.size());
    file[6] = std::byte{1};
    file[8] = static_cast<std::byte>(header.size() & 255U);
    file[9] = static_cast<std::byte>(header.size() >> 8U);
    std::memcpy(file.data() + prefix, header.data(), header.size());
    if (!bytes.empty())
        std::memcpy(file.data() + prefix + header.size(), bytes.data(), bytes.size());
    return file;
}

template <class T>
std::vector<std::byte> to_npy(const Raster<T>& raster)
{
    std::vector<std::size_t> shape{static_cast<std::size_t>(raster.height), static_cast<std::size_t>(raster.width)};
    if (raster.channels != 1)
        shape.push_back(static_cast<std::size_t>(raster.channels));
    return to_npy(form_of<T>().type, shape, std::as_bytes(std::span(raster.values)));
}

template <class T>
Raster<T> to_raster(const NpyArray& array, std::string_view source)
{
    constexpr std::size_t most = std::size_t{1} << 20U;
    const auto& shape = array.shape;
    const auto fail = [&](const std::string& what) { throw Error(std::string(source) + ": " + what); };
    if (shape.size() != 2 && shape.size() != 3)
        fail("expected an array H x W or H x W x C");
    if (std::max(shape[0], shape[1]) > most)
        fail("larger than 1048576 pixels along a side");
    if (array.type != form_of<T>().type)
        fail("array of type " + form_of(array.type).name() + "; expected " + form_of<T>().name());
    Raster<T> raster;
    raster.height = static_cast<int>(shape[0]);
    raster.width = static_cast<int>(shape[1]);
    raster.channels = shape.size() == 3 ? static_cast<int>(shape[2]) : 1;
    const auto values = array.as<T>();
    raster.values.assign(values.begin(), values.end());
    return raster;
}

template <class T>
void write_npy(const std::filesystem::path& file, const Raster<T>& raster)
{
    write_file(file, to_npy(raster));
}

template std::vector<std::byte> to_npy(const Raster8& raster);
template std::vector<std::byte> to_npy(const Raster16& raster);
template std::vector<std::byte> to_npy(const RasterF& raster);
template Raster8 to_raster(const NpyArray& array, std::string_view source);
template Raster16 to_raster(const NpyArray& array, std::string_view source);
template RasterF to_raster(const NpyArray& array, std::string_view source);
template void write_npy(const std::filesystem::path& file, const Raster8& raster);
template void write_npy(const std::filesystem::path& file, const Raster16& raster);
template void write_npy(const std::filesystem::path& file, const RasterF& raster);

}  // namespace fresco
