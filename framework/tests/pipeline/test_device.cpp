#include "catch.h"
#include "hand_made_catalog.h"

#include "pipeline/pipeline_options.h"

using namespace fresco::host;
using namespace fresco::host::testing;
using fresco::Value;

namespace
{

TypeDescription painter(const Value& versions)
{
    TypeDescription type = described("paint", "stage", R"json({
        "options": [{"name": "device", "kind": "text", "default": "auto", "choices": ["auto", "cpu", "cuda"], "help": ""}],
        "inputs": [], "outputs": []})json",
                                     {.device = "device"});
    type.library_versions = versions;
    return type;
}

std::string settled(const TypeDescription& type, const char* device, bool has_gpu)
{
    Value options = Value::Map{{"device", device}};
    settle_device(
        type, options, has_gpu ? +[] { return true; } : +[] { return false; });
    return options.at("device").as_string();
}

}  // namespace

TEST_CASE("auto is the GPU only where the machine has one and the plugin was built for it")
{
    const TypeDescription built_for_it = painter(Value::Map{{"libtorch", "2.1"}, {"cuda", "12"}});
    const TypeDescription other = painter(Value::Map{{"libtorch", "1.13"}});
    CHECK(settled(built_for_it, "auto", true) == "cuda");
    CHECK(settled(built_for_it, "auto", false) == "cpu");
    CHECK(settled(other, "auto", true) == "cpu");
    CHECK(settled(other, "cuda", false) == "cuda");
    CHECK(settled(built_for_it, "cpu", true) == "cpu");
}

TEST_CASE("a pipeline has what auto stands for, and knows which stages work on a GPU")
{
    Catalog catalog;
    catalog.add(painter(Value::Map{}));
    catalog.add(described("program", "stage", R"json({
        "options": [{"name": "gpu", "kind": "bool", "default": false, "help": ""}], "inputs": [], "outputs": []})json",
                          {.device = "gpu"}));
    const TemporaryFolder folder;
    const auto result = check(folder, R"(version: 1
stages:
  usual: {type: paint}
  there: {type: paint, device: cuda}
  plain: {type: program}
  other: {type: program, gpu: true}
)",
                              catalog);
    CHECK(lines(result).empty());
    CHECK(result.pipeline.find("usual")->options->at("device") == Value("cpu"));
    CHECK_FALSE(works_on_gpu(*result.pipeline.find("usual")));
    CHECK(works_on_gpu(*result.pipeline.find("there")));
    CHECK_FALSE(works_on_gpu(*result.pipeline.find("plain")));
    CHECK(works_on_gpu(*result.pipeline.find("other")));
}
