#include "catch.h"
#include "made_weights.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/weights/state_dict.h>

#include <cstring>
#include <string>

using namespace fresco;
using namespace fresco::weights;

namespace
{

/// A file with the given header text and `data` after it.
std::string file_text(const std::string& header, const std::string& data, std::int64_t stated = -1)
{
    const std::uint64_t length = stated >= 0 ? static_cast<std::uint64_t>(stated) : header.size();
    std::string text(8, '\0');
    std::memcpy(text.data(), &length, 8);
    return text + header + data;
}

/// How many tensors there are. Of bytes of the file's own size, so that a sanitizer sees the first beyond it.
std::size_t parsed(const std::string& text)
{
    const auto bytes = bytes_of(text);
    return parse_safetensors(bytes, "t.safetensors").tensors.size();
}

const std::string one = R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})";

}  // namespace

TEST_CASE("Tensors and metadata of a safetensors file by hand, and written from where they lie as they are copied together")
{
    const std::string header =
        R"({"b":{"dtype":"BOOL","shape":[1],"data_offsets":[6,7]},"__metadata__":{"step":"7"},)"
        R"("a":{"dtype":"I16","shape":[3,1],"data_offsets":[0,6]},"e":{"dtype":"F64","shape":[0,5],"data_offsets":[7,7]}} )";
    const auto bytes = bytes_of(file_text(header, std::string("123456\x01", 7)));
    const auto contents = parse_safetensors(bytes, "t.safetensors");
    CHECK(contents.metadata == std::map<std::string, std::string>{{"step", "7"}});
    REQUIRE(contents.tensors.size() == 3);
    const auto* a = contents.find("a");
    REQUIRE(a != nullptr);
    CHECK(a->type == ElementType::int16);
    CHECK(a->shape == std::vector<std::size_t>{3, 1});
    CHECK((a->bytes.data() == bytes.data() + 8 + header.size() && a->bytes.size() == 6));
    CHECK(contents.find("b")->bytes.data() == a->bytes.data() + 6);
    CHECK(contents.find("e")->bytes.empty());

    const fresco::testing::TemporaryFolder folder;
    write_safetensors(folder.path() / "t.safetensors", contents.tensors, contents.metadata);
    const auto together = to_safetensors(contents.tensors, contents.metadata);
    CHECK(read_file(folder.path() / "t.safetensors") == together);
    CHECK(parse_safetensors(together, "t.safetensors").tensors.size() == 3);
}

TEST_CASE("Damaged safetensors files are refused by name and place")
{
    const std::string eight(8, '\0');
    const auto refused = [&](const std::string& bytes, const std::string& what)
    {
        CAPTURE(bytes);
        CHECK_THROWS_WITH(parsed(bytes), Contains("t.safetensors: ") && Contains(what));
    };
    CHECK(parsed(file_text(one, eight)) == 1);
    refused("", "header length");
    refused(file_text(one, eight, std::int64_t{1} << 40), "4 MiB");
    const std::string largest = one + std::string((std::size_t{4} << 20U) - one.size(), ' ');
    CHECK(parsed(file_text(largest, eight)) == 1);
    CHECK_THROWS_WITH(parsed(file_text(largest + ' ', eight)), Contains("4194305 bytes is more than the 4 MiB allowed"));
    refused(file_text(one, "", 70), "byte 0: a header of 70 bytes");
    refused(file_text(" " + one, eight), "'{'");
    refused(file_text(one.substr(0, 20), ""), "header");
    refused(file_text(one, eight + "x"), "byte 70: bytes that belong to no tensor");
    refused(file_text(one, eight.substr(1)), "a.data_offsets[1]: beyond the end");
    refused(file_text(R"({"__metadata__":{"x":1}})", ""), "__metadata__.x: expected a text");

    struct Damage
    {
        const char* tensor;
        const char* what;
    };
    for (const auto& [tensor, what] :
         {Damage{R"("dtype":"F31","shape":[2],"data_offsets":[0,8])", "a.dtype: unknown type 'F31'"},
          {R"("dtype":"F32","shape":[3],"data_offsets":[0,8])", "the shape takes 12 bytes, the data_offsets give 8"},
          {R"("dtype":"F32","shape":[-2],"data_offsets":[0,8])", "a.shape[0]: expected an integer from 0"},
          {R"("dtype":"F32","shape":[4294967296,4294967296,2],"data_offsets":[0,8])", "a.shape[1]: the shape is too large"},
          {R"("dtype":"F32","shape":[2],"data_offsets":[8,0])", "beyond the end"},
          {R"("dtype":"F32","shape":[2])", "a.data_offsets: missing"},
          {R"("dtype":"F32","shape":[2],"data_offsets":[0,8],"more":1)", "a: unknown entry 'more'"},
          {R"("dtype":"BOOL","shape":[8],"data_offsets":[0,8]},"b":{"dtype":"U8","shape":[4],"data_offsets":[4,8])", "overlaps"},
          {R"("dtype":"BOOL","shape":[3],"data_offsets":[0,3]},"b":{"dtype":"U8","shape":[4],"data_offsets":[4,8])", "gap"},
          {R"("dtype":"F32","shape":[2],"data_offsets":[0,8]},"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8])", "twice"}})
        refused(file_text("{\"a\":{" + std::string(tensor) + "}}", eight), what);
}
