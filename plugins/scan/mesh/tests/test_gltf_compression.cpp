#include "bumpy_model.h"
#include "catch.h"

#include <fresco/error.h>

#include <meshoptimizer.h>

#include <algorithm>

using namespace fresco;
using namespace model_samples;
using scan_mesh::FileModel;

namespace
{

template <class T>
std::vector<T> values_of(const GltfSample& sample, std::size_t view)
{
    const auto offset = static_cast<std::size_t>(sample.views[view].at("byteOffset").as_int());
    std::vector<T> values(static_cast<std::size_t>(sample.views[view].at("byteLength").as_int()) / sizeof(T));
    std::memcpy(values.data(), sample.binary.data() + offset, values.size() * sizeof(T));
    return values;
}

/// Replaces a view by a stream; its plain form is nowhere.
void put_stream(GltfSample& sample, std::size_t view, std::vector<unsigned char> stream, std::size_t size, Value form)
{
    stream.resize(size);
    form.set("buffer", 0);
    form.set("byteOffset", sample.binary.size());
    form.set("byteLength", size);
    const auto bytes = std::as_bytes(std::span(stream));
    sample.binary.insert(sample.binary.end(), bytes.begin(), bytes.end());
    sample.binary.resize((sample.binary.size() + 3) / 4 * 4);
    sample.views[view].set("buffer", 1);
    sample.views[view].set("byteOffset", 0);
    sample.views[view].set("extensions", Value::Map{{"EXT_meshopt_compression", std::move(form)}});
}

/// meshoptimizer's filter, which has a mode from 0.19 on: exponents of their own.
template <class... Arguments>
void encode_exponential(Arguments... arguments)
{
    if constexpr (requires { meshopt_encodeFilterExp(arguments...); })
        meshopt_encodeFilterExp(arguments...);
    else
        meshopt_encodeFilterExp(arguments..., {});
}

void pack_rows(GltfSample& sample, std::size_t view, std::size_t stride, const char* filter)
{
    auto rows = values_of<unsigned char>(sample, view);
    const std::size_t count = rows.size() / stride;
    if (std::string_view(filter) == "EXPONENTIAL")
    {
        const auto floats = values_of<float>(sample, view);
        encode_exponential(static_cast<void*>(rows.data()), count, stride, 15, static_cast<const float*>(floats.data()));
    }
    meshopt_encodeVertexVersion(0);
    std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(count, stride));
    const std::size_t size = meshopt_encodeVertexBuffer(stream.data(), stream.size(), rows.data(), count, stride);
    put_stream(sample, view, stream, size,
               Value::Map{{"byteStride", stride}, {"count", count}, {"mode", "ATTRIBUTES"}, {"filter", filter}});
}

void pack_indices(GltfSample& sample, std::size_t view, bool as_triangles)
{
    const auto indices = values_of<std::uint32_t>(sample, view);
    std::vector<unsigned char> stream(10 * indices.size());
    meshopt_encodeIndexVersion(1);
    const std::size_t size = as_triangles
                                 ? meshopt_encodeIndexBuffer(stream.data(), stream.size(), indices.data(), indices.size())
                                 : meshopt_encodeIndexSequence(stream.data(), stream.size(), indices.data(), indices.size());
    put_stream(sample, view, stream, size,
               Value::Map{{"byteStride", 4}, {"count", indices.size()}, {"mode", as_triangles ? "TRIANGLES" : "INDICES"}});
}

GltfSample packed(const char* filter, bool as_triangles)
{
    BumpyModel model;
    GltfSample sample = model.finished();
    pack_rows(sample, model.positions_view, 12, filter);
    pack_rows(sample, model.texcoords_view, 8, "NONE");
    pack_indices(sample, model.indices_view, as_triangles);
    sample.rest.set(
        "buffers",
        Value::List{Value::Map{{"byteLength", sample.binary.size()}},
                    Value::Map{{"byteLength", 1 << 20},
                               {"extensions", Value::Map{{"EXT_meshopt_compression", Value::Map{{"fallback", true}}}}}}});
    for (const char* key : {"extensionsUsed", "extensionsRequired"})
        sample.rest.set(key, Value::List{"EXT_meshopt_compression"});
    return sample;
}

}  // namespace

TEST_CASE("EXT_meshopt_compression: the model that was packed", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    const FileModel plain = read_sample(BumpyModel().finished(), folder);
    for (const bool as_triangles : {false, true})
    {
        const FileModel same = read_sample(packed("NONE", as_triangles), folder);
        CHECK(same.mesh.positions == plain.mesh.positions);
        // Triangles may begin at another corner.
        CHECK(surface_of(same) == surface_of(plain));
        if (!as_triangles)
            CHECK(same.mesh.texcoords == plain.mesh.texcoords);
    }
    const FileModel near = read_sample(packed("EXPONENTIAL", true), folder);
    REQUIRE(near.mesh.positions.size() == plain.mesh.positions.size());
    for (std::size_t i = 0; i < near.mesh.positions.size(); ++i)
        CHECK(length(near.mesh.positions[i] - plain.mesh.positions[i]) < 1e-3F);
}

TEST_CASE("glTF: files of gltfpack and gltf-transform have the surface that was packed", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    for (const char* name : {"good_gltfpack.glb", "good_meshopt.glb", "good_quantized.glb", "good_webp.glb"})
    {
        CAPTURE(name);
        const FileModel model = scan_mesh::read_file_model(foreign_files() / "gltf" / name, true);
        check_bumpy(model);
        CHECK(model.pictures.size() == 1);
    }
}

TEST_CASE("EXT_meshopt_compression: damaged streams are refused with their view and offset", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    const GltfSample good = packed("NONE", true);
    const auto refused = [&](const auto& change, const std::string& reason)
    {
        GltfSample sample = good;
        change(sample);
        CHECK_THROWS_WITH(read_sample(sample, folder), Contains("a.glb: ") && Contains(reason));
    };
    const auto form = [](GltfSample& sample, std::size_t view) -> Value&
    { return *sample.views[view].find("extensions")->find("EXT_meshopt_compression"); };
    const auto entry = [&](const char* key, const Value& value, const std::string& reason)
    { refused([&](GltfSample& s) { form(s, 1).set(key, value); }, reason); };
    const std::string place = "bufferViews[1]: EXT_meshopt_compression: ";
    const std::string at =
        place + "byte " + std::to_string(good.views[1].at("extensions").at("EXT_meshopt_compression").at("byteOffset").as_int()) +
        " of buffer 0: ";
    entry("mode", "ROWS", at + "mode: expected ATTRIBUTES, TRIANGLES or INDICES");
    entry("filter", "QUATERNION", at + "filter: QUATERNION for rows of 12 bytes is not defined");
    entry("byteStride", 3, at + "a compressed stream of");
    entry("count", 121, "bufferViews[1]: ");
    entry("count", std::int64_t{1} << 40U, at + "a compressed stream of");
    entry("byteLength", 1 << 20, place + "1048576 bytes at ");
    entry("buffer", 3, place + "buffer 3 of 2");
    entry("count", -1, "expected a whole number");
    refused([](GltfSample& s) { s.views[1].set("byteLength", 7); }, "bufferViews[1]: byteLength: expected count x byteStride");
    refused([](GltfSample& s) { s.views[2].as_map().pop_back(); }, "bufferViews[2]: ");
    // Many views of one stream.
    refused(
        [](GltfSample& s)
        {
            for (int i = 0; i < 50; ++i)
                s.views.push_back(s.views[1]);
        },
        "compressed parts overlap");
    // Flipped bytes: an error or a mesh that can be used.
    for (std::size_t i = 0; i < good.binary.size(); ++i)
    {
        GltfSample sample = good;
        sample.binary[i] ^= std::byte{0x5A};
        try
        {
            check_mesh(read_sample(sample, folder).mesh, "the model");
        }
        catch (const Error&)
        {
        }
    }
}

TEST_CASE("glTF: WebP and AVIF pictures, by themselves or beside others; variants are told of", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    const std::string webp("RIFF\4\0\0\0WEBPVP8L", 16);
    const std::string avif("\0\0\0\x10"
                           "ftypavif\0\0\0\0",
                           16);
    const auto read = [&](const char* extension, const std::string& picture, bool with_fallback)
    {
        BumpyModel model;
        Value::List images{Value::Map{{"bufferView", model.sample.add_view(std::vector<char>(picture.begin(), picture.end()))}}};
        Value texture = Value::Map{{"extensions", Value::Map{{extension, Value::Map{{"source", 0}}}}}};
        if (with_fallback)
        {
            images.emplace_back(Value::Map{{"bufferView", model.sample.add_view(stored_png::encode(Raster8(1, 1, 3, 9)))}});
            texture.set("source", 1);
        }
        model.primitive.set("material", 0);
        model.sample.rest.set("images", images);
        model.sample.rest.set("textures", Value::List{texture});
        model.sample.rest.set("extensionsRequired", Value::List{extension});
        model.sample.rest.set("extensionsUsed", Value::List{extension, "KHR_materials_variants"});
        model.sample.rest.set("materials", Value::List{Value::Map{{"pbrMetallicRoughness",
                                                                   Value::Map{{"baseColorTexture", Value::Map{{"index", 0}}}}}}});
        return read_sample(model.finished(), folder);
    };
    const auto begin = [](const FileModel& model) { return std::to_integer<char>(model.pictures.at(0).bytes.at(0)); };
    CHECK(begin(read("EXT_texture_webp", webp, false)) == 'R');
    CHECK(begin(read("EXT_texture_webp", webp, true)) == '\x89');
    CHECK(scan_mesh::suffix_of(read("EXT_texture_webp", webp, false).pictures[0].bytes) == ".webp");
    CHECK(scan_mesh::suffix_of(read("EXT_texture_avif", avif, false).pictures[0].bytes) == ".heic");
    CHECK_THAT(read("EXT_texture_webp", webp, false).warnings.at(0), Contains("KHR_materials_variants"));
    CHECK_THROWS_WITH(read("EXT_texture_webp", "RIFF\4...WAVE", false), Contains("images[0]: not PNG, JPEG, WebP or AVIF"));
}
