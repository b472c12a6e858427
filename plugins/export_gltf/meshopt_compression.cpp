#include "meshopt_compression.h"

#include "glb_parts.h"

#include <fresco/error.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/value.h>

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <span>
#include <vector>

using namespace fresco;
using fresco::gltf::entry;
using fresco::texturing::WeldedMesh;

namespace
{
constexpr const char* extension = "EXT_meshopt_compression";

template <class T>
void reorder(std::vector<T>& values, const std::vector<unsigned>& remap)
{
    if (values.empty())
        return;
    std::vector<T> result(values.size());
    meshopt_remapVertexBuffer(result.data(), values.data(), values.size(), sizeof(T), remap.data());
    values = std::move(result);
}

void align(std::string& bytes)
{
    bytes.resize((bytes.size() + 3) / 4 * 4);
}

std::string first_bytes(std::string stream, std::size_t count)
{
    if (count == 0 || count > stream.size())
        throw Error("meshoptimizer could not compress the mesh");
    stream.resize(count);
    return stream;
}

unsigned char* raw(std::string& bytes)
{
    return reinterpret_cast<unsigned char*>(bytes.data());
}

std::string encoded_rows(std::string_view rows, std::size_t stride)
{
    // The versions that EXT_meshopt_compression names, here and below.
    meshopt_encodeVertexVersion(0);
    std::string stream(meshopt_encodeVertexBufferBound(rows.size() / stride, stride), '\0');
    return first_bytes(stream, meshopt_encodeVertexBuffer(raw(stream), stream.size(), rows.data(), rows.size() / stride, stride));
}

std::string encoded_triangles(std::string_view bytes, std::size_t stride)
{
    std::vector<unsigned> indices(bytes.size() / stride);
    for (std::size_t i = 0; i < indices.size(); ++i)
        std::memcpy(&indices[i], bytes.data() + i * stride, stride);
    meshopt_encodeIndexVersion(1);
    std::string stream(meshopt_encodeIndexBufferBound(indices.size(), *std::ranges::max_element(indices) + std::size_t{1}), '\0');
    return first_bytes(stream, meshopt_encodeIndexBuffer(raw(stream), stream.size(), indices.data(), indices.size()));
}

std::size_t size_at(const Value& map, std::string_view key)
{
    const Value* const found = map.find(key);
    return found == nullptr ? 0 : static_cast<std::size_t>(found->as_int());
}

/// The bytes that a view, or its compressed form, names.
std::string_view stored(std::string_view binary, const Value& view, const std::string& place)
{
    const std::size_t offset = size_at(view, "byteOffset");
    const std::size_t length = size_at(view, "byteLength");
    if (size_at(view, "buffer") != 0 || offset > binary.size() || length > binary.size() - offset)
        throw Error(fmt::format("{}{} bytes at {} do not fit into the BIN chunk of {}", place, length, offset, binary.size()));
    return binary.substr(offset, length);
}

std::string decoded(std::string_view stream, const Value& compressed, const std::string& place)
{
    const std::size_t count = size_at(compressed, "count");
    const std::size_t stride = size_at(compressed, "byteStride");
    const std::string& mode = compressed.at("mode").as_string();
    const bool is_rows = mode == "ATTRIBUTES";
    if (!is_rows && mode != "TRIANGLES")
        throw Error(place + "mode: expected ATTRIBUTES or TRIANGLES");
    // No stream holds more; and the decoder takes what it is told for granted.
    const bool is_possible = is_rows ? stride > 0 && stride <= 256 && stride % 4 == 0 && count / 256 <= stream.size()
                                     : (stride == 2 || stride == 4) && count % 3 == 0 && count / 3 <= stream.size();
    std::string result(is_possible ? count * stride : 0, '\0');
    const auto* const begin = reinterpret_cast<const unsigned char*>(stream.data());
    if (result.empty() || (is_rows ? meshopt_decodeVertexBuffer(result.data(), count, stride, begin, stream.size())
                                   : meshopt_decodeIndexBuffer(result.data(), count, stride, begin, stream.size())) != 0)
        throw Error(fmt::format("{}a compressed stream of {} bytes does not hold {} {} of {} bytes", place, stream.size(), count,
                                is_rows ? "rows" : "indices", stride));
    return result;
}

/// The extensions that a list of the document names, without this one.
Value::List others(const Value& document, const char* key)
{
    Value::List names;
    if (const Value* const list = document.find(key))
        names = list->as_list();
    std::erase(names, Value(extension));
    return names;
}
}  // namespace

void order_for_compression(WeldedMesh& mesh)
{
    const std::size_t vertices = mesh.positions.size();
    std::vector<unsigned> indices(mesh.indices.size());
    meshopt_optimizeVertexCacheStrip(indices.data(), mesh.indices.data(), mesh.indices.size(), vertices);
    std::vector<unsigned> remap(vertices);
    meshopt_optimizeVertexFetchRemap(remap.data(), indices.data(), indices.size(), vertices);
    meshopt_remapIndexBuffer(mesh.indices.data(), indices.data(), indices.size(), remap.data());
    reorder(mesh.positions, remap);
    reorder(mesh.normals, remap);
    reorder(mesh.texcoords, remap);
    reorder(mesh.colors, remap);
}

std::string compressed_glb(std::string_view glb)
{
    auto [document, plain] = parts_of(glb);
    // Views of accessors come first, in the accessors' order; then the picture's, which stays as it is. Views of compressed data
    // lie in buffer 1, which no file holds.
    const Value::List& accessors = document.at("accessors").as_list();
    Value::List& views = document.find("bufferViews")->as_list();
    std::string binary;
    std::size_t restored_bytes = 0;
    for (std::size_t i = 0; i < views.size(); ++i)
    {
        Value& view = views[i];
        const std::string_view bytes = stored(plain, view, entry("bufferViews", i));
        const std::size_t offset = binary.size();
        if (i < accessors.size())
        {
            const std::size_t count = size_at(accessors[i], "count");
            const std::size_t stride = bytes.size() / std::max(count, std::size_t{1});
            const bool is_rows = size_at(view, "target") == TINYGLTF_TARGET_ARRAY_BUFFER;
            binary += is_rows ? encoded_rows(bytes, stride) : encoded_triangles(bytes, stride);
            view.set("extensions", Value::Map{{extension, Value::Map{{"buffer", 0},
                                                                     {"byteOffset", offset},
                                                                     {"byteLength", binary.size() - offset},
                                                                     {"byteStride", stride},
                                                                     {"count", count},
                                                                     {"mode", is_rows ? "ATTRIBUTES" : "TRIANGLES"}}}});
            view.set("buffer", 1);
            view.set("byteOffset", restored_bytes);
            if (is_rows)
                view.set("byteStride", stride);
            restored_bytes = (restored_bytes + bytes.size() + 3) / 4 * 4;
        }
        else
        {
            binary += bytes;
            view.set("byteOffset", offset);
        }
        align(binary);
    }
    document.set("buffers", Value::List{Value::Map{{"byteLength", binary.size()}},
                                        Value::Map{{"byteLength", restored_bytes},
                                                   {"extensions", Value::Map{{extension, Value::Map{{"fallback", true}}}}}}});
    for (const char* const key : {"extensionsUsed", "extensionsRequired"})
    {
        Value::List names = others(document, key);
        names.emplace_back(extension);
        document.set(key, std::move(names));
    }
    return assembled(document, binary);
}

std::string restored_glb(std::string_view glb)
{
    auto [document, compressed] = parts_of(glb);
    std::string binary(compressed);
    Value* const views = document.find("bufferViews");
    for (std::size_t i = 0; views != nullptr && i < views->as_list().size(); ++i)
    {
        Value& view = views->as_list()[i];
        const Value* const extensions = view.find("extensions");
        const Value* const form = extensions == nullptr ? nullptr : extensions->find(extension);
        if (form == nullptr)
            continue;
        const std::string place = entry("bufferViews", i);
        const std::string rows = decoded(stored(compressed, *form, place), *form, place);
        if (rows.size() != size_at(view, "byteLength"))
            throw Error(fmt::format("{}byteLength: expected count x byteStride, {}", place, rows.size()));
        view.set("extensions", Value::Map{});
        view.set("buffer", 0);
        view.set("byteOffset", binary.size());
        binary += rows;
        align(binary);
    }
    if (binary.size() == compressed.size())
        return {};
    Value::List required = others(document, "extensionsRequired");
    if (required.size() == document.at("extensionsRequired").as_list().size())
        throw Error("extensionsRequired: expected " + std::string(extension) + ", which bufferViews use");
    document.set("extensionsRequired", std::move(required));
    document.set("extensionsUsed", others(document, "extensionsUsed"));
    document.set("buffers", Value::List{Value::Map{{"byteLength", binary.size()}}});
    return assembled(document, binary);
}
