#include "base/text_layout.h"
#include "catch.h"
#include "run/file_origin.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <array>
#include <sstream>

using Catch::Contains;
using fresco::Value;
using namespace fresco::host;

namespace
{

std::string word(std::size_t number)
{
    std::string bytes;
    for (int i = 0; i < 4; ++i)
        bytes += static_cast<char>(number >> (8 * i) & 255U);
    return bytes;
}

std::string glb(const std::string& json)
{
    return "glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON" + json;
}

const char* const origin = R"({"versions": {"OpenCV": "4.6.0", "fresco": "0.1"}, "stages": [
    {"stage": "texture.synthesize", "options": {"stroke_cm": 4.0, "mask": {"file": "m.png", "xxh128": "77"}},
     "inputs": {"mesh": "atlas.project", "style": {"file": "waves.jpg", "xxh128": "0123"}}, "figures": {"up": [0, 0, 1]}},
    {"stage": "export.gltf", "options": {}, "inputs": {}}]})";

}  // namespace

TEST_CASE("describe prints how a GLB was made")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "room.glb";
    fresco::write_file(file, glb(R"({"asset": {"version": "2.0", "extras": )" + std::string(origin) + "}}"));
    std::ostringstream text;
    write_file_origin(file, false, without_end, text);
    CHECK(text.str() == file.string() + ": made with OpenCV 4.6.0, fresco 0.1\n"
                                        "\ntexture.synthesize\n"
                                        "  input   mesh       atlas.project\n"
                                        "  input   style      waves.jpg (xxh128 0123)\n"
                                        "  option  stroke_cm  4.0\n"
                                        "  option  mask       m.png (xxh128 77)\n"
                                        "  figure  up         [0,0,1]\n"
                                        "\nexport.gltf\n");
    std::ostringstream json;
    write_file_origin(file, true, without_end, json);
    CHECK(fresco::parse_json(json.str()) == fresco::parse_json(origin));
}

TEST_CASE("describe refuses what is no GLB, is cut short or says nothing of its origin, by name")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "room.glb";
    const auto refused = [&](const std::string& bytes, const std::string& reason)
    {
        fresco::write_file(file, bytes);
        CHECK_THROWS_WITH(file_origin(file), Contains("room.glb: ") && Contains(reason));
    };
    const std::string whole = glb(R"({"asset": {"extras": )" + std::string(origin) + "}}");
    for (std::size_t length = 0; length < whole.size(); length += length < 40 ? 1 : 37)
        refused(whole.substr(0, length), length < 20 ? "is not a binary glTF 2.0 file" : "ends within its JSON chunk");
    refused("glTF" + word(1) + whole.substr(8), "is not a binary glTF 2.0 file");
    refused("glTF" + word(2) + word(99) + word(std::size_t{1} << 31U) + "JSON{}", "more than 64 MiB");
    refused(glb("{"), "JSON");
    for (const char* silent : {"{}", "[]", R"({"asset": 3})", R"({"asset": {"extras": {"stages": []}}})"})
        refused(glb(silent), "does not say how it was made");
    for (const char* wrong : {R"({"stages": 1, "versions": {}})", R"({"stages": [1], "versions": {}})",
                              R"({"stages": [{"stage": "a"}], "versions": {}})", R"({"stages": [], "versions": {"a": 1}})"})
    {
        fresco::write_file(file, glb(R"({"asset": {"extras": )" + std::string(wrong) + "}}"));
        std::ostringstream text;
        CHECK_THROWS_AS(write_file_origin(file, false, without_end, text), fresco::Error);
    }
    CHECK_THROWS_AS(file_origin(folder.path() / "gone.glb"), fresco::MissingInput);
}
