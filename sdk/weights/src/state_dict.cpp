#include <fresco/weights/state_dict.h>

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace fresco::weights
{
namespace
{

static_assert(std::endian::native == std::endian::little, "weights are little-endian and read as they lie");

struct TypeFacts
{
    std::string_view name;
    std::size_t size;
};
constexpr std::array<TypeFacts, 10> type_facts{
    {{"F64", 8}, {"I64", 8}, {"F32", 4}, {"I32", 4}, {"F16", 2}, {"BF16", 2}, {"I16", 2}, {"U8", 1}, {"I8", 1}, {"BOOL", 1}}};

const TypeFacts& facts(ElementType type)
{
    return type_facts[static_cast<std::size_t>(type)];
}

template <class T>
T element(const TensorView& tensor, std::size_t i)
{
    T value;
    std::memcpy(&value, tensor.bytes.data() + i * sizeof(T), sizeof(T));
    return value;
}

/// IEEE 754 half precision.
float from_half(std::uint16_t bits)
{
    const float sign = (bits & 0x8000U) != 0 ? -1.0F : 1.0F;
    const int exponent = (bits >> 10U) & 0x1f;
    const float fraction = static_cast<float>(bits & 0x3ffU);
    if (exponent == 0x1f)
        return fraction == 0 ? sign * INFINITY : NAN;
    if (exponent == 0)
        return sign * std::ldexp(fraction, -24);
    return sign * std::ldexp(1024.0F + fraction, exponent - 25);
}

float number(const TensorView& tensor, std::size_t i)
{
    switch (tensor.type)
    {
    case ElementType::float64:
        return static_cast<float>(element<double>(tensor, i));
    case ElementType::float16:
        return from_half(element<std::uint16_t>(tensor, i));
    case ElementType::bfloat16:
        return std::bit_cast<float>(static_cast<std::uint32_t>(element<std::uint16_t>(tensor, i)) << 16U);
    default:
        return element<float>(tensor, i);
    }
}

}  // namespace

bool is_floating(ElementType type)
{
    return type == ElementType::float64 || type == ElementType::float32 || type == ElementType::float16 ||
           type == ElementType::bfloat16;
}

std::size_t size_of(ElementType type)
{
    return facts(type).size;
}

std::string_view name_of(ElementType type)
{
    return facts(type).name;
}

std::string_view name_of(Form form)
{
    return form == Form::safetensors ? "safetensors" : form == Form::legacy_pickle ? "legacy pickle" : "zip pickle";
}

std::string shape_text(std::span<const std::size_t> shape)
{
    std::string text;
    for (const auto size : shape)
        text += (text.empty() ? "" : " x ") + std::to_string(size);
    return text.empty() ? "one number" : text;
}

std::vector<float> to_float32(const TensorView& tensor, std::string_view source)
{
    const std::string where = std::string(source) + ": tensor '" + tensor.name + "' ";
    if (!is_floating(tensor.type))
        throw Error(where + "does not hold floating-point numbers");
    std::vector<float> values(tensor.count());
    for (std::size_t i = 0; i < values.size(); ++i)
    {
        values[i] = number(tensor, i);
        if (!std::isfinite(values[i]))
            throw Error(where + "holds values that are not finite");
    }
    return values;
}

const TensorView* StateDict::find(std::string_view name) const
{
    const auto found = std::ranges::find(tensors, name, &TensorView::name);
    return found == tensors.end() ? nullptr : &*found;
}

StateDict parse_state_dict(std::span<const std::byte> bytes, std::string_view source)
{
    const auto begins = [&](std::string_view text, std::size_t offset = 0)
    { return bytes.size() >= offset + text.size() && std::memcmp(bytes.data() + offset, text.data(), text.size()) == 0; };
    if (begins("PK"))
        return parse_zip_pickle(bytes, source);
    if (begins("\x80") && !begins("{", 8))
        return parse_legacy_pickle(bytes, source);
    if (begins("ustar", 257))
        throw Error(std::string(source) +
                    ": is a tar archive, as PyTorch wrote them before 0.1.10; load it with torch.load and save "
                    "it again with torch.save");
    return parse_safetensors(bytes, source);
}

WeightsFile read_weights(const std::filesystem::path& file)
{
    WeightsFile result;
    result.bytes = read_file(file, std::size_t{1} << 32U);
    result.contents = parse_state_dict(result.bytes, file.string());
    return result;
}

std::vector<FileFormat> file_formats()
{
    const std::string name = "a safetensors file or a PyTorch state dict";
    const std::vector<std::string> extensions{".safetensors", ".pth", ".pt"};
    return {{.name = name, .extensions = extensions, .begins = {"{"}, .begins_at = 8, .length_bytes = 8, .length_from = 8},
            {.name = name, .extensions = extensions, .begins = {"PK\x03\x04", "\x80"}}};
}

}  // namespace fresco::weights
