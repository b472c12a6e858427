#include <fresco/gltf/compression.h>

#include <fresco/error.h>

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <string_view>

namespace fresco::gltf
{
namespace
{

/// A byte of the stream holds at most so many: even where nothing changes, a block of 256 rows has 2 bits for each of their
/// bytes.
constexpr std::size_t most_bytes_per_byte = 1024;

std::string_view word_or(const Value& form, std::string_view key, std::string_view otherwise)
{
    const Value* const found = form.find(key);
    return found == nullptr ? otherwise : std::string_view(found->as_string());
}

}  // namespace

std::vector<std::byte> meshopt_decoded(std::span<const std::byte> stream, const Value& form, const std::string& place)
{
    const auto count = static_cast<std::size_t>(form.at("count").as_int());
    const auto stride = static_cast<std::size_t>(form.at("byteStride").as_int());
    const std::string_view mode = word_or(form, "mode", "");
    const std::string_view filter = word_or(form, "filter", "NONE");
    const bool is_rows = mode == "ATTRIBUTES";
    const bool is_triangles = mode == "TRIANGLES";
    if (!is_rows && !is_triangles && mode != "INDICES")
        throw Error(place + "mode: expected ATTRIBUTES, TRIANGLES or INDICES");
    const bool is_octahedral = filter == "OCTAHEDRAL" && (stride == 4 || stride == 8);
    const bool is_quaternion = filter == "QUATERNION" && stride == 8;
    const bool is_exponential = filter == "EXPONENTIAL" && stride % 4 == 0;
    if (filter != "NONE" && !(is_rows && (is_octahedral || is_quaternion || is_exponential)))
        throw Error(
            fmt::format("{}filter: {} for {} of {} bytes is not defined", place, filter, is_rows ? "rows" : "indices", stride));
    // No stream holds more; and the decoder takes what it is told for granted.
    const bool is_possible =
        is_rows ? stride > 0 && stride <= 256 && stride % 4 == 0 && count / most_bytes_per_byte <= stream.size() / stride
                : (stride == 2 || stride == 4) && count / 3 <= stream.size() && (!is_triangles || count % 3 == 0);
    std::vector<std::byte> result(is_possible ? count * stride : 0);
    const auto* const begin = reinterpret_cast<const unsigned char*>(stream.data());
    const auto decode = [&]
    {
        if (is_rows)
            return meshopt_decodeVertexBuffer(result.data(), count, stride, begin, stream.size());
        return is_triangles ? meshopt_decodeIndexBuffer(result.data(), count, stride, begin, stream.size())
                            : meshopt_decodeIndexSequence(result.data(), count, stride, begin, stream.size());
    };
    if (result.empty() || decode() != 0)
        throw Error(fmt::format("{}a compressed stream of {} bytes does not hold {} {} of {} bytes: the file is damaged", place,
                                stream.size(), count, is_rows ? "rows" : "indices", stride));
    if (is_octahedral)
        meshopt_decodeFilterOct(result.data(), count, stride);
    else if (is_quaternion)
        meshopt_decodeFilterQuat(result.data(), count, stride);
    else if (is_exponential)
        meshopt_decodeFilterExp(result.data(), count, stride);
    return result;
}

}  // namespace fresco::gltf
