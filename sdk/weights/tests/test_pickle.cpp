#include "made_weights.h"
#include "pickle.h"

#include <fmt/format.h>

using namespace fresco::weights::detail;
using namespace std::string_literals;

namespace
{

/// The error of a pickle of protocol 2 with these operations, or nothing.
std::string error_of(const std::string& operations)
{
    const auto bytes = bytes_of("\x80\x02" + operations);
    PickleMachine machine(bytes, "p");
    return fresco::testing::error_of([&] { machine.run(); });
}

std::int64_t integer_of(const std::string& operations)
{
    const auto bytes = bytes_of("\x80\x02" + operations + ".");
    PickleMachine machine(bytes, "p");
    const Node& node = machine.run();
    REQUIRE(node.kind == Kind::integer);
    return node.integer;
}

const std::string float_storage = "ctorch\nFloatStorage\n";

}  // namespace

TEST_CASE("Integers of all sizes")
{
    CHECK(integer_of("K\xff") == 255);
    CHECK(integer_of("M\x01\x02") == 513);
    CHECK(integer_of("J\xfe\xff\xff\xff") == -2);
    CHECK(integer_of("\x8a\x00"s) == 0);
    CHECK(integer_of("\x8a\x01\xff"s) == -1);
    CHECK(integer_of("\x8a\x05\x00\x00\x00\x00\x01"s) == 4294967296);
}

TEST_CASE("Operations and globals outside the list are refused")
{
    for (int code = 0; code < 256; ++code)
    {
        const std::string known = "NJKMGXTU\x88\x89\x80\x8a\x95\x8c\x94qrhj()t]}aesucQRb.\x93\x85\x86\x87\x81";
        const std::string operation(1, static_cast<char>(code));
        CAPTURE(code);
        const bool refused = error_of(operation + std::string(300, '\0')).starts_with("p: byte 2: the operation");
        CHECK(refused == (known.find(operation) == std::string::npos));
    }
    CHECK_THAT(error_of("cos\nsystem\n."), Catch::Contains("'os.system'") && Catch::Contains("nothing was executed"));
    CHECK_THAT(error_of("cbuiltins\neval\n."), Catch::Contains("'builtins.eval'"));
    CHECK_THAT(error_of("ctorch\n\x1b[2J\n."), Catch::Contains("'torch.?[2J'"));
    CHECK_THAT(error_of("X\x02\0\0\0osX\x06\0\0\0system\x93."s), Catch::Contains("'os.system'"));
    CHECK_THAT(error_of(float_storage + ")R."), Catch::Contains("cannot be called"));
    CHECK_THAT(error_of("ccollections\nOrderedDict\n)\x81."), Catch::Contains("no state dict needs"));
    CHECK_THAT(error_of("K\x01}b."s), Catch::Contains("attributes"));
    CHECK(error_of("ccollections\nOrderedDict\n)R.").empty());
}

TEST_CASE("A stack that runs empty, marks and slots that are missing")
{
    CHECK_THAT(error_of("."), Catch::Contains("more or less than one"));
    CHECK_THAT(error_of("R."), Catch::Contains("missing on the stack"));
    CHECK_THAT(error_of("t."), Catch::Contains("mark is missing"));
    CHECK_THAT(error_of("q\0."s), Catch::Contains("missing on the stack"));
    CHECK_THAT(error_of("Nq\x05h\x04."), Catch::Contains("is empty"));
    CHECK_THAT(error_of("}N(Nu."), Catch::Contains("other than a container"));
    CHECK_THAT(error_of("\x80\x02N."), Catch::Contains("protocol"));
    CHECK_THAT(error_of("X\xff\xff\xff\x7f."), Catch::Contains("2147483647"));
    CHECK_THAT(error_of("\x95\xff\xff\xff\xff\xff\xff\xff\xffN."), Catch::Contains("frame"));
    CHECK_THAT(error_of("cabc"), Catch::Contains("line without an end"));
}

TEST_CASE("Nothing grows without bounds")
{
    const auto repeated = [](const std::string& text, std::size_t count)
    { return fmt::format("{}", fmt::join(std::vector<std::string_view>(count, text), "")); };
    CHECK_THAT(error_of("N" + repeated("q\1", 600'000) + "."), Catch::Contains("more than 1 MiB"));
    // A list of 500 entries, made into dicts again and again.
    CHECK_THAT(
        error_of("](" + repeated("(NNt", 500) + "e\x85q\1ccollections\nOrderedDict\nq\2" + repeated("h\2h\1R", 2000) + "."),
        Catch::Contains("containers with more than"));
    CHECK_THAT(error_of("Nq\1(" + repeated("h\1", 20) + "tq\2ccollections\nOrderedDict\nh\2R."), Catch::Contains("arguments"));
}

TEST_CASE("Storages and tensors are checked when they are named")
{
    const auto storage = [](const std::string& key, const std::string& count, const std::string& type = float_storage)
    { return "(U\7storage" + type + "U" + std::string(1, static_cast<char>(key.size())) + key + "U\3cpu" + count + "tQ"; };
    const std::string tensor = "ctorch._utils\n_rebuild_tensor\n(";
    CHECK(error_of(tensor + storage("0", "K\6") + "K\0K\2K\3\x86K\3K\1\x86tR."s).empty());
    CHECK_THAT(error_of(tensor + storage("0", "K\6") + "K\1K\2K\3\x86K\3K\1\x86tR."), Catch::Contains("larger than its storage"));
    CHECK_THAT(error_of(tensor + storage("0", "K\6") + "K\0K\2K\3\x86K\3\x85tR."s), Catch::Contains("stride"));
    CHECK_THAT(error_of(tensor + storage("0", "K\6") + "K\0K\2K\3\x86K\1K\2\x86tR."s), Catch::Contains("row-major"));
    CHECK_THAT(error_of(tensor + storage("0", "K\6") + "K\0J\xff\xff\xff\xff\x85K\1\x85tR."s), Catch::Contains("shape"));
    CHECK_THAT(error_of(tensor + "NK\0))tR."s), Catch::Contains("without a storage"));
    CHECK_THAT(error_of(storage("0", "J\xff\xff\xff\xff") + "."), Catch::Contains("negative"));
    CHECK_THAT(error_of(storage("0", "K\6", "ccollections\nOrderedDict\n") + "."), Catch::Contains("without a type"));
    CHECK_THAT(error_of(storage("0", "K\6") + storage("0", "K\7") + "\x86."), Catch::Contains("two types or sizes"));
    CHECK_THAT(error_of("(NNtQ."), Catch::Contains("other than a storage"));
    CHECK_THAT(error_of("ctorch._utils\n_rebuild_parameter\nN\x85R."), Catch::Contains("without a tensor"));
}
